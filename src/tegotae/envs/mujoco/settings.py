"""What a MuJoCo model is as an environment: its feet, its control period, an episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.envs.mujoco.sensing import Sensing, sensing


@dataclass(frozen=True, kw_only=True)
class ModelSettings:
    """A MuJoCo model as an environment, `tegotae.envs.mujoco.env.ModelEnv`.

    Args:
        model: an MJCF file, its text, or the name of a model of this package: `hopper`, `leg` or
            `quadruped`. A file of another installed package is `PACKAGE:FILE`.
        feet: names of the bodies or geoms whose contact forces are observed.
        control_s: time for which an action is held [s].
        duration_s: length of an episode [s].
        release_m: how much higher than in the model the first body is released [m].
        noise: standard deviation of what is added to all positions at a reset [m or rad].
        fallen_share: the episode ends when the first body is lower than this share of its height in
            the model, or its axis has tipped below the horizontal.
        ground: whether to add a level floor at height 0, for a model of a robot alone.
        without: names of bodies and geoms of the model to leave out, such as a wall.
        servo_nm_per_rad: makes of every motor of a joint a position servo of this stiffness
            [N m/rad, or N/m], whose command is the joint's position; 0 leaves motors as they are.
        mass_factor: what all masses and inertias are multiplied by, to test robustness.
        friction_factor: what all sliding friction is multiplied by, likewise.
        effort: what a unit of work, over weight and length, costs in the reward.

    Raises:
        TegotaeError: for a number out of its range, or names that are none.
    """

    model: str | Path
    feet: Sequence[str] = ()
    control_s: float = 0.01
    duration_s: float = 24.0
    release_m: float = 0.0
    noise: float = 0.0
    fallen_share: float = 0.3
    ground: bool = False
    without: Sequence[str] = ()
    servo_nm_per_rad: float = 0.0
    mass_factor: float = 1.0
    friction_factor: float = 1.0
    effort: float = 0.1

    def __post_init__(self) -> None:
        for name in ("control_s", "duration_s", "mass_factor", "friction_factor"):
            require_finite(name, getattr(self, name), above=0.0)
        for name in ("release_m", "noise", "effort", "servo_nm_per_rad"):
            require_finite(name, getattr(self, name), least=0.0)
        require_finite("fallen_share", self.fallen_share, least=0.0, most=1.0)
        if not isinstance(self.ground, bool):
            raise TegotaeError(f"ground is {self.ground!r}; it must be true or false")
        for name, what in (("feet", "bodies or geoms"), ("without", "bodies and geoms")):
            names = getattr(self, name)
            if not isinstance(names, (list, tuple)) or not all(isinstance(n, str) for n in names):
                raise TegotaeError(f"{name} is {names!r}; it must be a list of names of {what}")

    @property
    def sensed(self) -> Sensing:
        """The model, fitted, with sensors for all that a leg can feel.

        Raises:
            TegotaeError: for a model that cannot be read, or that lacks what is named of it.
            MissingExtraError: without MuJoCo.
        """
        return sensing(
            self.model,
            self.feet,
            ground=self.ground,
            without=self.without,
            servo_nm_per_rad=self.servo_nm_per_rad,
            mass_factor=self.mass_factor,
            friction_factor=self.friction_factor,
        )


PACKAGED = {
    "hopper": ModelSettings(model="hopper", feet=("foot",), control_s=0.002, release_m=0.2),
    "leg": ModelSettings(model="leg", feet=("foot",), control_s=0.005, release_m=0.05),
    "quadruped": ModelSettings(
        model="quadruped",
        feet=("foot0", "foot1", "foot2", "foot3"),
        # Ten of its time steps, which follow from the walker's own time unit.
        control_s=10 * 0.005 * (0.2 / 9.81) ** 0.5,
        noise=0.01,
    ),
}
"""The models of this package as environments, by name."""
