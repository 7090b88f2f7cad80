"""`tegotae figure surface`: the actuation surface, and the limit cycle on it (Fig. 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae._support.errors import require_count, require_finite
from tegotae._support.limits import MOST_M, MOST_POINTS, require_within
from tegotae.cli.figure.policy import PolicySubject
from tegotae.cli.options import UNSET
from tegotae.parts.bodies import Hopper

if TYPE_CHECKING:
    from tegotae.analysis import Orbit
    from tegotae.analysis.surface import Surface
    from tegotae.envs.policies import Policy


@dataclass(frozen=True, kw_only=True)
class _Drawn:
    """Whose surface is drawn: a controller's, or a policy's."""

    body: Hopper
    title: str
    sees_velocity: bool
    orbit: Callable[[], Orbit]
    surface: Callable[..., Surface]


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
        from tegotae.analysis import NoLimitCycleError
        from tegotae.figures.maps import surface_figure, surface_tables

        self.check_out()
        require_count("resolution", self.resolution, least=2, most=MOST_POINTS)
        require_within("velocity", self.velocity, MOST_M)
        policy = self.loaded()
        subject = self._of_controller() if policy is None else self._of_policy(policy)
        body, note = subject.body, subject.title
        self._check_force(body)
        try:
            orbit = subject.orbit()
        except NoLimitCycleError as none:
            print(f"{none}; the surface is drawn without it")
            orbit = None
        most = self.spring_force
        if most is None:
            typical = 3.0 * body.weight_n if orbit is None else 1.1 * orbit.spring_force_n.max()
            most = min(typical, body.stiffness_n_per_m * body.rest_length_m)
        fastest = 4.0 if orbit is None else 1.1 * float(np.abs(orbit.velocity_m_per_s).max())
        found = subject.surface(
            np.linspace(0.0, most, self.resolution),
            columns=self.resolution,
            velocity_m_per_s=self.velocity,
            velocity_range_m_per_s=(-fastest, fastest),
        )
        if found.phase_rad is not None and subject.sees_velocity:
            note += f", slice at ẏ = {self.velocity:g} m/s"
        figure = surface_figure(found, orbit, max_force_n=float(body.max_force_n), note=note)
        self.write(figure, surface_tables(found, orbit))

    def _of_controller(self) -> _Drawn:
        from tegotae.analysis import actuation_surface, sees_velocity

        saved = self.saved()
        assert isinstance(saved.body, Hopper)  # `chosen` refuses others
        return _Drawn(
            body=saved.body,
            title=self.title(saved),
            sees_velocity=sees_velocity(saved),
            orbit=lambda: self.orbit(saved),
            surface=partial(actuation_surface, saved),
        )

    def _of_policy(self, policy: Policy) -> _Drawn:
        from tegotae.analysis.policy import (
            measured_policy,
            policy_orbit,
            policy_paths,
            policy_surface,
        )

        def orbit() -> Orbit:
            height_m, phase_rad = self.released
            paths = policy_paths(
                policy, np.array([height_m]), phase_rad=phase_rad, duration_s=self.settle
            )
            return policy_orbit(paths, measured_policy(policy, paths))

        return _Drawn(
            body=policy.meaning.body,
            title=self.policy_title(policy),
            sees_velocity="velocity" in policy.meaning.settings.observed,
            orbit=orbit,
            surface=partial(policy_surface, policy),
        )

    def _check_force(self, body: Hopper) -> None:
        if self.spring_force is not None:
            most = body.stiffness_n_per_m * body.rest_length_m  # that of a leg of no length
            require_finite("spring_force", self.spring_force, above=0.0, most=most)
