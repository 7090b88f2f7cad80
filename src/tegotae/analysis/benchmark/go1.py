"""The subject of another simulator: Unitree's Go1 in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np

from tegotae.analysis.benchmark.subject import STARTS, TRACKS, Driver, Entry, Subject, of_walk
from tegotae.analysis.generalisation.on_environment import ModelUnderTest
from tegotae.envs.mujoco.sensing import sensing
from tegotae.systems.resolve import resolve
from tegotae.training.collection import sets_of

_LAW = "zoo:ART-rF-tphif-w8@go1"
"""Whose training has the robot's servos, feet and starts."""
_TORSO = ("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate")


@dataclass(frozen=True)
class Go1Subject(Subject):
    """Unitree's Go1, whose joints are position servos. The score of an episode is that of a walk
    (`of_walk`), at a wanted speed of 0.5 m/s.

    Args:
        model: the robot's file, go1.xml.
    """

    NAME = "go1"
    CONDITIONS = ("mass=0.85/1.2", "friction=0.5", "push-ahead=-0.3/0.3", "push-aside=0.3")
    SPEED = 0.5

    model: str

    @cached_property
    def tested(self) -> ModelUnderTest:
        """The robot, as `generalise` would test it."""
        (runs, *_) = sets_of(resolve(_LAW))
        assert runs.task is not None
        task = msgspec.structs.replace(runs.task, env=self.model, duration_s=8.0, sha256={})
        runs = msgspec.structs.replace  # type: ignore[assignment]
        raise NotImplementedError(task, runs)
