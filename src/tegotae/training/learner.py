"""What learns: a population or an agent, as a run asks it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from tegotae._support.documents import Json, JsonObject
from tegotae.parts.controller import Controller
from tegotae.training.curve_file import CurvePoint
from tegotae.training.trainable import Trainable


class LearningStep(NamedTuple):
    """What a session did since the step before."""

    done: int
    """How far it is, of the session's `length`."""
    report: str
    """How it goes, in a few words."""
    points: tuple[CurvePoint, ...]
    """The new points of the learning curves."""


@dataclass(frozen=True, eq=False)
class LearnedController:
    """What the training of one seed has come to.

    Args:
        controller: the controller, as it is with these weights.
        weights: the best that were found, shape [n_weights].
        outcome: the result of the training: `seed`, `best_fitness`, and the learner's own entries.
    """

    controller: Controller
    weights: np.ndarray
    outcome: Mapping[str, Json]


class Session(ABC):
    """The learning of one run: it goes on step by step, and its state goes into a checkpoint."""

    @property
    @abstractmethod
    def length(self) -> int:
        """What `LearningStep.done` counts to."""

    @abstractmethod
    def steps(self) -> Iterator[LearningStep]:
        """Learn until every seed has ended. An interrupt between steps loses nothing."""

    @abstractmethod
    def points(self) -> list[CurvePoint]:
        """The learning curves of all seeds until here."""

    @abstractmethod
    def learned(self) -> list[LearnedController]:
        """What every seed that has begun has come to."""

    @abstractmethod
    def arrays(self) -> dict[str, np.ndarray]:
        """The state that a later session goes on from, by name; empty if there is none to keep."""

    @abstractmethod
    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take up the state of an earlier session.

        Raises:
            TegotaeError: for a state that is further than the session is to go.
            ValueError, KeyError or TypeError: for arrays that are no such state.
        """


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
    def check(self, experiment: Trainable) -> None:
        """Raise `TegotaeError` if it cannot learn this experiment."""

    @abstractmethod
    def configuration(self, experiment: Trainable, seeds: tuple[int, ...]) -> JsonObject:
        """What decides the result, but for how long is learned, as JSON values."""

    @abstractmethod
    def session(self, experiment: Trainable, seeds: tuple[int, ...]) -> Session:
        """The learning of an experiment, not yet begun.

        Raises:
            TegotaeError: for what cannot be learned, kept or held in memory.
        """
