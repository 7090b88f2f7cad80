"""The contract of a learner, and what a training comes to."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeAlias

import numpy as np

from tegotae._support.documents import Json, JsonObject
from tegotae.parts.controller import Controller

if TYPE_CHECKING:
    from tegotae.systems.experiment import Experiment
    from tegotae.training.environments.experiment import EnvExperiment


class CurvePoint(NamedTuple):
    """A point of a learning curve; its fields are the columns of `curves.csv`."""

    seed: int
    step: float
    simulated_s: float
    fitness: float
    cot_inverse: float
    mean_fitness: float = math.nan
    best_fitness: float = math.nan
    failed_share: float = math.nan


@dataclass(frozen=True, eq=False)
class LearnedController:
    """What the training of one seed has come to.

    Args:
        controller: the controller, as it is with these weights.
        weights: the best so far, shape [n_weights].
        outcome: the result of the training: `seed`, `best_fitness`, and the learner's own entries.
    """

    controller: Controller
    weights: np.ndarray
    outcome: Mapping[str, Json]


@dataclass(frozen=True, eq=False)
class TrainingState:
    """What a training has come to after a step: its results, and all that it goes on from.

    Args:
        done: how far it is, of the learner's `length`.
        report: how it goes, in a few words.
        points: the learning curves of all seeds.
        new: the points of the last step.
        learned: the controllers, of every seed that has begun.
        arrays: the learner's own state by name; empty if it begins anew.
    """

    done: int = 0
    report: str = ""
    points: tuple[CurvePoint, ...] = ()
    new: tuple[CurvePoint, ...] = ()
    learned: tuple[LearnedController, ...] = ()
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])


Trainable: TypeAlias = "Experiment | EnvExperiment"
"""What is learned: an experiment on the engine, or on an environment."""


class Learner(ABC):
    """How is learned and for how long: a frozen dataclass of its settings."""

    UNIT: ClassVar[str]
    """What it counts, such as "generation"."""

    @property
    @abstractmethod
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""

    @abstractmethod
    def engine(self, experiment: Trainable) -> str:
        """The engine that rolls the episodes out (`tegotae._support.engines`)."""

    @abstractmethod
    def check(self, experiment: Trainable, seeds: tuple[int, ...]) -> None:
        """Raise `TegotaeError` if it cannot learn this experiment from so many seeds."""

    @abstractmethod
    def configuration(self, experiment: Trainable, seeds: tuple[int, ...]) -> JsonObject:
        """What decides the result, but for how long is learned, as JSON values."""

    @abstractmethod
    def length(self, seeds: tuple[int, ...]) -> int:
        """What `TrainingState.done` counts to."""

    @abstractmethod
    def learn(
        self, experiment: Trainable, seeds: tuple[int, ...], state: TrainingState | None = None
    ) -> Iterator[TrainingState]:
        """Learn until every seed has ended; between steps an interrupt loses nothing.

        Args:
            experiment: what is learned.
            seeds: one training from random weights each.
            state: where it goes on (`resumed`), or None from the beginning.
        """

    @abstractmethod
    def resumed(
        self,
        experiment: Trainable,
        seeds: tuple[int, ...],
        points: tuple[CurvePoint, ...],
        arrays: Mapping[str, np.ndarray],
    ) -> TrainingState:
        """The state of an earlier training, of which the points and the arrays are kept.

        Raises:
            TegotaeError: for a state that is further than this learner is to go.
            ValueError, KeyError or TypeError: for arrays that are no such state.
        """


def versions_of(*packages: str) -> dict[str, str]:
    """Versions of the programs that decide the numbers: these packages and what all need."""
    return {name: version(name) for name in ("tegotae", "jax", "jaxlib", *packages, "numpy")}
