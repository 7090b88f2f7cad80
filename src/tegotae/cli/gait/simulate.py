"""`tegotae gait simulate`: one release, its footfalls and its lags."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.cli.gait.subject import Subject
from tegotae.cli.options import UNSET
from tegotae.cli.tables import print_rows

if TYPE_CHECKING:
    from tegotae.studies.gaits.simulate import GaitRun


@dataclass(frozen=True, kw_only=True)
class Simulate(Subject):
    """Release a body once: footfall diagram, lags over time, duty factors, and its gait's name."""

    phases: Annotated[tuple[float, ...], UNSET] = ()
    """Phases of the legs at release [cycles], in the body's order; random ones by default."""
    animate: bool = False
    """Also write an animation of the last strides (.gif)."""

    def run(self) -> None:
        """Simulate, write, and print."""
        from tegotae.figures.gaits.footfall import footfall_figure
        from tegotae.figures.gaits.lags import lags_figure
        from tegotae.studies.gaits.document import coordination_columns, write
        from tegotae.studies.gaits.simulate import columns, simulate

        if self.phases and self.seed:
            raise TegotaeError("--seed is of random phases, and --phases says what they are")
        legged = self.legged()
        phases = [2.0 * math.pi * phase for phase in self.phases] or None
        run = simulate(legged, phases, seed=self.seed, tolerance=self.tolerance)
        found = {k: v[0] for k, v in coordination_columns(run.found, legged.names).items()}
        title = f"{self.title(legged)}: {run.gait}"
        document = self.document(
            legged,
            "simulate",
            gait=run.gait,
            release_phase_rad=run.phase_rad,
            coordination=found,
            stances={
                name: [list(stance) for stance in leg]
                for name, leg in zip(legged.names, run.stances, strict=True)
            },
        )
        written = [
            self.draw(footfall_figure(run, title), "footfall"),
            self.draw(lags_figure(run, title), "lags"),
            *write(self.out, "simulate", document, columns(run)),
        ]
        if self.animate:
            from tegotae.figures.gaits.animation import write_animation

            written.append(write_animation(run, self.out / "animation.gif"))
        _print(run)
        self.wrote(written)


def _print(run: GaitRun) -> None:
    length, time = run.legged.units
    found = run.found
    print(run.gait)
    print_rows(
        ("leg", "lag [cycles]", "footfall lag", "duty factor", f"steps [1/{time}]"),
        (
            (
                name,
                _number(found.lag[leg, 0] % 1.0),
                _number(found.touchdown_lag[leg, 0] % 1.0),
                _number(found.duty_factor[leg, 0]),
                _number(found.step_frequency_hz[leg, 0]),
            )
            for leg, name in enumerate(run.legged.names)
        ),
    )
    for what, values, unit in (
        ("locked after", found.lock_time_s, time),
        ("order parameter", found.order_parameter, ""),
        ("speed", found.speed_m_per_s, f"{length}/{time}"),
        ("cost of transport", found.cost_of_transport, ""),
        ("Froude number", found.froude, ""),
        ("fell at", found.fall_time_s, time),
    ):
        if np.isfinite(values[0]):
            print(f"{what} {values[0]:.3g} {unit}".rstrip())


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3f}"
