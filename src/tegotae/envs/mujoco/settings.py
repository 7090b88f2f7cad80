"""Settings of a MuJoCo model, and how its episodes begin and end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.envs.mujoco.sensing import Sensing, is_sound, sensing


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


class Fate:
    """Rewards and ends of lanes that are stepped together.

    Args:
        settings: of the model.
        sensing: the model.
        step_s: control period [s].
        lanes: how many.
    """

    def __init__(
        self, settings: ModelSettings, sensing: Sensing, step_s: float, lanes: int = 1
    ) -> None:
        model = sensing.model
        self.steps = max(1, round(settings.duration_s / step_s))
        self._settings = settings
        self._at = {n: sensing.names.index(f"root_{n}") for n in ("forward", "height", "upright")}
        gravity = float(np.linalg.norm(model.opt.gravity)) or 1.0
        self._weight_n = float(model.body_mass.sum()) * gravity
        self._length_m = np.ones(lanes)
        self._done = np.zeros(lanes, int)
        self._seen = np.zeros((2, lanes))

    def begin(self, seen: np.ndarray, where: np.ndarray | None = None) -> None:
        """A new episode, from what is observed at its start [lanes, entries].

        Args:
            seen: what is observed.
            where: of which lanes, [lanes]; of all by default.
        """
        if where is None:
            where = np.ones(len(seen), bool)
        height = seen[where, self._at["height"]] - self._settings.release_m
        self._length_m[where] = np.maximum(height, 1e-6)
        self._done[where] = 0
        self._seen[0, where], self._seen[1, where] = seen[where, self._at["forward"]], 0.0

    def after(
        self, seen: np.ndarray, work_j: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Reward, whether it has fallen and whether the time is up, [lanes] each."""
        self._done += 1
        forward, before = seen[:, self._at["forward"]], self._seen
        went = (forward - before[0]) / self._length_m
        spent = (work_j - before[1]) / (self._weight_n * self._length_m)
        self._seen = np.stack([forward, work_j])
        low = seen[:, self._at["height"]] < self._settings.fallen_share * self._length_m
        fallen = low | (seen[:, self._at["upright"]] < 0.0) | ~is_sound(seen).all(axis=1)
        return went - self._settings.effort * spent, fallen, self._done >= self.steps
