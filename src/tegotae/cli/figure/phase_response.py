"""`tegotae figure phase-response`: the phase-response curve to a short push."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae.cli.figure.controller import SettledSubject


@dataclass(frozen=True, kw_only=True)
class PhaseResponseFigure(SettledSubject):
    """Shift of the rhythm by a short push, over the phase of the push in the limit cycle."""

    push: tuple[float, ...] = (0.005, -0.005)
    """Impulses [N s]; positive ones act upward."""
    points: int = 60
    """Number of points of the limit cycle."""
    cycles: int = 40
    """Number of cycles to wait."""

    def run(self) -> None:
        """Compute, write, and say where the rhythm is most sensitive."""
        from tegotae.analysis.phase_response import check_pushes, measure_phase_response
        from tegotae.figures.cycles import (
            NEGLIGIBLE_RAD,
            phase_response_figure,
            phase_response_table,
        )
        from tegotae.parts.bodies import Hopper

        self.check_out()
        saved = self.saved()
        if isinstance(saved.body, Hopper):
            check_pushes(np.array(self.push), saved.body, self.points, self.cycles)
        orbit = self.orbit(saved)
        found = measure_phase_response(
            saved, orbit, np.array(self.push), points=self.points, cycles=self.cycles
        )
        for push, shift in zip(found.push_ns, found.shift_rad, strict=True):
            back = np.isfinite(shift)
            if not back.any():
                print(f"push of {push:g} N s: no return to the limit cycle")
                continue
            most = np.nanargmax(np.abs(shift))
            where = found.cycle_phase_rad[most] / (2.0 * np.pi)
            negligible = abs(shift[most]) < NEGLIGIBLE_RAD
            print(
                f"push of {push:g} N s: largest shift {shift[most]:+.3g} rad at t/T = {where:.2f}"
                + (", which is negligible" if negligible else "")
                + ("" if back.all() else f"; no return from {np.mean(~back):.0%} of the points")
            )
        self.write(
            phase_response_figure(found, self.title(saved)), {"": phase_response_table(found)}
        )
