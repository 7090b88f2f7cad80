"""`tegotae figure surface`: the actuation surface, and the limit cycle on it (Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tegotae._support.errors import require_count, require_finite
from tegotae._support.limits import MOST_M, MOST_POINTS, require_within
from tegotae.cli.figure.policy import PolicySubject
from tegotae.cli.options import UNSET
from tegotae.parts.bodies import Hopper


@dataclass(frozen=True, kw_only=True)
class SurfaceFigure(PolicySubject):
    """Actuator force over phase and spring force, with the limit cycle on it (Fig. 5)."""

    velocity: float = 0.0
    """Velocity of the slice [m/s], for controllers that sense the velocity."""
    spring_force: Annotated[float | None, UNSET] = None
    """Largest spring force [N]; a tenth above the limit cycle's by default."""
    resolution: int = 200
    """Points along either axis."""

    def run(self) -> None:
        """Compute and write; what has no limit cycle has its surface alone."""
        from tegotae.analysis.orbit import NoLimitCycleError
        from tegotae.analysis.surface import actuation_surface, sees_velocity
        from tegotae.figures.maps import surface_figure, surface_tables

        self.check_out()
        require_count("resolution", self.resolution, least=2, most=MOST_POINTS)
        require_within("velocity", self.velocity, MOST_M)
        driven = self.loaded() or self.saved()
        body, note = self.hopper_of(driven), self.title(driven)
        self._check_force(body)
        try:
            orbit = self.orbit(driven)
        except NoLimitCycleError as none:
            print(f"{none}; the surface is drawn without it")
            orbit = None
        most = self.spring_force
        if most is None:
            typical = 3.0 * body.weight_n if orbit is None else 1.1 * orbit.spring_force_n.max()
            most = min(typical, body.stiffness_n_per_m * body.rest_length_m)
        fastest = 4.0 if orbit is None else 1.1 * float(np.abs(orbit.velocity_m_per_s).max())
        found = actuation_surface(
            driven,
            np.linspace(0.0, most, self.resolution),
            columns=self.resolution,
            velocity_m_per_s=self.velocity,
            velocity_range_m_per_s=(-fastest, fastest),
        )
        if found.phase_rad is not None and sees_velocity(driven):
            note += f", slice at ẏ = {self.velocity:g} m/s"
        figure = surface_figure(found, orbit, max_force_n=float(body.max_force_n), note=note)
        self.write(figure, surface_tables(found, orbit))

    def _check_force(self, body: Hopper) -> None:
        if self.spring_force is not None:
            most = body.stiffness_n_per_m * body.rest_length_m  # that of a leg of no length
            require_finite("spring_force", self.spring_force, above=0.0, most=most)
