"""The contract of a learner, of what it learns, and its curves on disk."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from tegotae._support.documents import Json, JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.tables import numbers, parse_csv, write_csv
from tegotae.parts.controller import Controller
from tegotae.systems.controller_set import EnvTask
from tegotae.systems.system import System


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


COLUMNS = CurvePoint._fields
"""The columns of `curves.csv`."""


def write_curves(path: Path, points: Sequence[CurvePoint]) -> None:
    """Write the points of all seeds, each seed's together.

    Args:
        path: the file.
        points: of all seeds, in any order.
    """
    rows = sorted(points, key=lambda point: (point.seed, point.step))
    columns = {name: [getattr(row, name) for row in rows] for name in COLUMNS}
    write_csv(path, columns, digits=6)


def curves_of(path: Path) -> Mapping[str, np.ndarray]:
    """The columns `COLUMNS` of a `curves.csv`, shape [points] each.

    Args:
        path: the file.

    Raises:
        TegotaeError: for a file that cannot be read or is no such table.
    """
    try:
        cells = parse_csv(path.read_text(encoding="utf-8"))
        if tuple(cells) != COLUMNS:
            raise ValueError(f"its columns are not {', '.join(COLUMNS)}")
        columns = {name: numbers(map(str, column)) for name, column in cells.items()}
        if len({len(column) for column in columns.values()}) > 1:
            raise ValueError("rows of unequal length")
        if not np.isfinite(columns["simulated_s"]).all():
            raise ValueError("a simulated time is missing")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    return columns


class Trainable(Protocol):
    """An experiment on the engine (`tegotae.systems.experiment`), or on an environment."""

    @property
    def name(self) -> str:
        """What it is called, in files, tables and figures."""
        ...

    @property
    def controller(self) -> Controller:
        """The structure whose weights are learned."""
        ...

    @property
    def omega(self) -> float | None:
        """Prescribed frequency [rad/s]; None without an oscillator."""
        ...

    @property
    def system(self) -> System:
        """The closed loop, as controller files have it."""
        ...

    @property
    def task(self) -> EnvTask | None:
        """The task on an environment; None on the engine."""
        ...

    @property
    def document(self) -> JsonObject:
        """The experiment as plain JSON values."""
        ...

    @property
    def episodes(self) -> int:
        """How many episodes each candidate has."""
        ...

    @property
    def duration_s(self) -> float:
        """Length of an episode [s], if nothing ends it before."""
        ...

    @property
    def cot_unit(self) -> str:
        """The unit of CoT⁻¹ in which its fitness measures it."""
        ...

    @property
    def is_searched(self) -> bool:
        """Whether all there is to learn is a constant gain, which a search finds."""
        ...

    @property
    def gains(self) -> np.ndarray:
        """The gains that such a search tries."""
        ...

    def check(self) -> None:
        """Raise `TegotaeError` if it cannot be trained."""
        ...


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
