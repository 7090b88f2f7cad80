"""What a disturbance is: a condition outside of the training, from none of it on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.parts._shapes import LaneNumbers
from tegotae.simulation.world import Change

MOST_LEVEL = 1e6
"""The largest level of any disturbance: single precision can count with it."""


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

    name: str
    label: str
    unit: str = ""
    neutral: float = 0.0
    levels: tuple[float, ...] = ()
    measure: str = "keeps"

    def __post_init__(self) -> None:
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, least=-MOST_LEVEL, most=MOST_LEVEL)
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

    @abstractmethod
    def lacks(self, tested: ControllersUnderTest) -> str:
        """Why this condition does not apply to these controllers; empty if it does."""

    @abstractmethod
    def changes(
        self, tested: ControllersUnderTest, level: np.ndarray, at_s: np.ndarray
    ) -> dict[str, LaneNumbers]:
        """The changes for lanes of these levels, by name (`with_changes`).

        Arrays [lanes] or [limbs, lanes], or schedules of them; names are those of the prepared
        body's fields, and of the scenario's entries.

        Args:
            tested: the controllers that meet it.
            level: of each lane, [lanes]; releases are the innermost (`release_of`).
            at_s: when what happens at a time happens in it [s], [lanes].
        """


def release_of(tested: ControllersUnderTest, level: np.ndarray) -> np.ndarray:
    """Which release of its run every lane is, from 0 on, [lanes].

    What is drawn follows from it alone: what a run meets does not depend on which others there are.
    """
    return np.arange(len(level)) % tested.starts


def usual_change(change: Change, usual: LaneNumbers) -> Change:
    """A change of the same kind and times that leaves what it belongs to as it is."""
    first = type(change)._fields[0]
    value = usual if first == "value" else 0.0
    return change._replace(**{first: value})
