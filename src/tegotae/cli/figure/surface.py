"""`tegotae figure surface`: the actuation surface, and the limit cycle on it (Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae.bodies import Hopper
from tegotae.cli.figure.subject import SettledSubject
from tegotae.cli.options import UNSET
from tegotae.errors import require_count, require_finite
from tegotae.limits import MOST_M, MOST_POINTS, require_within

if TYPE_CHECKING:
    from tegotae.controller_file import SavedController


@dataclass(frozen=True, kw_only=True)
class Surface(SettledSubject):
    """Actuator force over phase and spring force, with the limit cycle on it (Fig. 5)."""

    velocity: float = 0.0
    """Velocity that controllers which sense it are shown: the slice [m/s]."""
    spring_force: Annotated[float | None, UNSET] = None
    """Largest spring force [N]; a tenth above the limit cycle's by default."""
    resolution: int = 200
    """Points along either axis."""

    def run(self) -> None:
        """Compute and write; a controller without limit cycle has its surface alone."""
        from tegotae.analysis import NoLimitCycleError, actuation_surface, sees_velocity
        from tegotae.figures.surface import surface_figure, surface_tables

        self.check_out()
        require_count("resolution", self.resolution, least=2, most=MOST_POINTS)
        require_within("velocity", self.velocity, MOST_M)
        saved = self.saved()
        self._check_force(saved)
        try:
            orbit = self.orbit(saved)
        except NoLimitCycleError as none:
            print(f"{none}; the surface is drawn without it")
            orbit = None
        body = saved.body
        assert isinstance(body, Hopper)  # `chosen` refuses others
        most = self.spring_force
        if most is None:
            typical = 3.0 * body.weight_n if orbit is None else 1.1 * orbit.spring_force_n.max()
            most = min(typical, body.stiffness_n_per_m * body.rest_length_m)
        fastest = 4.0 if orbit is None else 1.1 * float(np.abs(orbit.velocity_m_per_s).max())
        found = actuation_surface(
            saved,
            np.linspace(0.0, most, self.resolution),
            columns=self.resolution,
            velocity_m_per_s=self.velocity,
            velocity_range_m_per_s=(-fastest, fastest),
        )
        note = self.title(saved)
        if found.phase_rad is not None and sees_velocity(saved):
            note += f", slice at ẏ = {self.velocity:g} m/s"
        figure = surface_figure(found, orbit, max_force_n=float(body.max_force_n), note=note)
        self.write(figure, surface_tables(found, orbit))

    def _check_force(self, saved: SavedController) -> None:
        body = saved.body
        if self.spring_force is not None and isinstance(body, Hopper):
            most = body.stiffness_n_per_m * body.rest_length_m  # that of a leg of no length
            require_finite("spring_force", self.spring_force, above=0.0, most=most)
