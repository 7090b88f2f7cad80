"""What is tried and what it is tried on: conditions outside of the training, and controllers."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.summary import has_mass, total_mass_kg
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.controller import Controller
from tegotae.systems.controller_file import ControllerSet

MOST_LEVEL = 1e6
"""The largest level of any disturbance: single precision can count with it."""


class LackingError(Exception):
    """A body lacks what a disturbance changes; the text says what."""


@dataclass(frozen=True, kw_only=True)
class Disturbance(ABC):
    """One condition at several levels: a frozen dataclass of its numbers.

    Args:
        name: what commands and tables call it.
        label: what figures call it.
        unit: of its levels; empty for a ratio.
        neutral: the level at which there is none of it.
        levels: those that are tried, below and above the neutral one, in any order.
        measure: what of a gait is to be kept: "keeps", that it is the same; or "moves", that the
            body still hops or walks, where the same gait cannot be.

    Raises:
        TegotaeError: for no level, one that is no number or beyond sense, twice the same, or the
            neutral one.
    """

    RANGE: ClassVar[Mapping[str, float]] = {"least": -MOST_LEVEL}
    """The lowest possible level (`require_finite`)."""

    name: str
    label: str
    unit: str = ""
    neutral: float = 0.0
    levels: tuple[float, ...] = ()
    measure: str = "keeps"

    def __post_init__(self) -> None:
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, most=MOST_LEVEL, **self.RANGE)
        if not self.levels or len(set(self.levels)) < len(self.levels):
            raise TegotaeError(
                f"the levels of {self.name} are {self.levels}; give at least one, each once"
            )
        if self.neutral in self.levels:
            raise TegotaeError(f"{self.neutral:g} is no {self.name} at all; it is always tested")

    @property
    def longest_delay_s(self) -> float:
        """By how much it makes the senses late at most, for a leg of a metre on Earth [s]."""
        return 0.0

    def side(self, below: bool) -> list[float]:
        """Levels on one side of the neutral one, from there outwards."""
        levels = sorted(level for level in self.levels if (level < self.neutral) == below)
        return levels[::-1] if below else levels

    @property
    def outwards(self) -> list[float]:
        """All levels, side by side."""
        return [*self.side(True), *self.side(False)]

    @abstractmethod
    def changes(
        self, tested: Tested, level: np.ndarray, at_s: np.ndarray
    ) -> dict[str, LaneNumbers]:
        """The changes for lanes of these levels, by name (`with_changes`).

        Arrays [lanes] or [limbs, lanes], or schedules of them; names are those of the body's
        fields, and of the scenario's entries.

        Args:
            tested: the controllers that meet it.
            level: of each lane, [lanes]; releases are the innermost (`release_of`).
            at_s: when what happens at a time happens in it [s], [lanes].

        Raises:
            LackingError: if it does not apply to these controllers.
        """


@dataclass(frozen=True)
class Tested(ABC):
    """A set of controllers, unchanged, and how it is tried: on bodies of this package
    (`ControllersUnderTest`), or in another simulator (`ModelUnderTest`).

    Args:
        controllers: the runs of one training, and the system that they share.
        starts: from how many releases each is tried.
    """

    CHANGED: ClassVar[frozenset[str] | None] = None
    """Names of what can be changed; None for all that the body has."""

    controllers: ControllerSet
    starts: int = 1

    @classmethod
    def of(cls, runs: ControllerSet, starts: int = 4) -> Self:
        """The runs of a set, without duplicates, ready for a test.

        Args:
            runs: the runs.
            starts: where releases differ.
        """
        _, first = np.unique(runs.weights, axis=0, return_index=True)
        kept = np.sort(first)
        labels = tuple(runs.labels[i] for i in kept)
        tested = cls(dataclasses.replace(runs, weights=runs.weights[kept], labels=labels))
        return dataclasses.replace(tested, starts=starts) if tested.starts_differ else tested

    @property
    def name(self) -> str:
        """Of the set."""
        return self.controllers.name

    @property
    def weights(self) -> np.ndarray:
        """Of the runs, [runs, n_weights]."""
        return self.controllers.weights

    @property
    def controller(self) -> Controller:
        """The structure that the runs share."""
        return self.controllers.controller

    @property
    def size(self) -> int:
        """How many lanes a level has: runs, each from every start."""
        return len(self.weights) * self.starts

    @property
    @abstractmethod
    def document(self) -> JsonObject:
        """What decides what is found, beside the disturbances, as JSON values."""

    @property
    @abstractmethod
    def starts_differ(self) -> bool:
        """Whether releases differ, so that several are worth a try."""

    @property
    @abstractmethod
    def omega(self) -> float | None:
        """The frequency they are tried at [rad/s]; None without an oscillator."""

    @property
    @abstractmethod
    def body(self) -> Any:
        """What the controllers move: it has `rest_length_m`, `touching_height_m` and `limbs`."""

    @property
    def unwrapped(self) -> Any:
        """The body within all that is around it."""
        return self.body

    @property
    def kind(self) -> str:
        """What the body is called."""
        return type(self.unwrapped).__name__

    @property
    def takes_forces(self) -> bool:
        """Whether its actuators take forces, and not places of feet."""
        return True

    @property
    def mass_kg(self) -> float:
        """Of the body [kg].

        Raises:
            LackingError: if it does not say what it weighs.
        """
        if not has_mass(self.unwrapped):
            raise LackingError(f"a {self.kind} has no mass_kg")
        return float(total_mass_kg(self.unwrapped))

    @property
    @abstractmethod
    def height_m(self) -> float:
        """From which height it is released [m]."""

    @property
    @abstractmethod
    def time_scale(self) -> float:
        """√(l0 / g) of the body over that of a leg of a metre on Earth: 1 for the hopper."""

    @property
    def speed_scale(self) -> float:
        """√(g l0) of the body over that of a leg of a metre on Earth: 1 for the hopper."""
        return float(self.unwrapped.rest_length_m) / self.time_scale

    @abstractmethod
    def has_field(self, name: str) -> bool:
        """Whether the body has a field of this name."""

    @abstractmethod
    def usual(self, name: str) -> LaneNumbers:
        """A field of the body as it is: a number, or a tuple of the legs' numbers.

        Raises:
            LackingError: if there is none of this name.
        """

    def lacks(self, disturbance: Disturbance) -> str:
        """Why a disturbance does not apply; empty if it does."""
        try:
            changes = disturbance.changes(self, np.array([disturbance.neutral]), np.zeros(1))
        except LackingError as lacking:
            return str(lacking)
        beyond = sorted(changes.keys() - self.CHANGED) if self.CHANGED is not None else []
        return f"{', '.join(beyond)} cannot be changed on a {self.kind}" if beyond else ""

    @abstractmethod
    def check(self, disturbances: Sequence[Disturbance]) -> None:
        """Raise `TegotaeError` if a level of a disturbance makes no body, or one, or an oscillator,
        that is too quick for the control tick."""

    @abstractmethod
    def kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """What is kept at every level of disturbances that apply (`Retention`), [levels, lanes].

        Levels are those of one disturbance after the other (`Disturbance.outwards`).
        """


def release_of(tested: Tested, level: np.ndarray) -> np.ndarray:
    """Which release of its run every lane is, from 0 on, [lanes].

    What is drawn follows from it alone: what a run meets does not depend on which others there are.
    """
    return np.arange(len(level)) % tested.starts
