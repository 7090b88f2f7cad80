"""`tegotae figure poincare`: the apex section, and the decay of disturbances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae.cli.figure.controller import SettledSubject


@dataclass(frozen=True, kw_only=True)
class PoincareFigure(SettledSubject):
    """Apexes from the release on, Floquet multipliers, and the decay of a small deviation."""

    step: float = 1e-4
    """Step of the finite differences [m, rad]."""
    nudge: float = 0.01
    """Initial deviation from the limit cycle for the observed decay [m]."""
    turns: int = 40
    """Number of cycles over which the decay is observed."""

    def run(self) -> None:
        """Compute, write, and print the multipliers."""
        from tegotae.analysis.poincare import check_disturbances, poincare_section, transient
        from tegotae.figures.cycles import poincare_figure, poincare_tables

        self.check_out()
        check_disturbances(self.step, self.nudge, self.turns)
        saved = self.saved()
        orbit = self.orbit(saved)
        found = poincare_section(saved, orbit, step=self.step, nudge=self.nudge, turns=self.turns)
        apexes = transient(saved, duration_s=self.settle)
        hops = "1 hop" if found.hops == 1 else f"{found.hops} hops"
        print(f"limit cycle of {hops}, {found.period_s:.4f} s")
        if not found.refined:
            print("the fixed point was not refined; the apex at which the gait settled replaces it")
        for value in found.multipliers:
            shown = f"{value.real:.4f}" if value.imag == 0.0 else f"{value:.4f}"
            print(f"Floquet multiplier {shown}, |λ| = {abs(value):.4f}")
        if np.isfinite(found.observed):
            print(f"observed decay: {found.observed:.4f} per turn")
        if np.isfinite(found.decay_s):
            print(f"a disturbance shrinks to 1/e in {found.decay_s:.3f} s")
        figure = poincare_figure(found, apexes, self.title(saved))
        self.write(figure, poincare_tables(found, apexes))
