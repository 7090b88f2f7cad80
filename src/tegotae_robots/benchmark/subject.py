"""Subjects of the benchmark: the actuators and senses that an entry has, and the scores of its
episodes."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, other_code
from tegotae.analysis.generalisation.disturbances import Disturbance, disturbances_named
from tegotae.measures.statistics import POSITIVE, interval, share_interval

Policy: TypeAlias = Callable[[np.ndarray], np.ndarray]
"""Map from an observation [entries] to an action [actions], step after step of one episode."""
Entry: TypeAlias = Callable[[], Policy]
"""Begins an episode: a policy with a state of its own."""

TRACKS = ("load", "load+imu", "all")
"""Each senses what the one before it does, and more."""
MOST_CPU_S = 3600.0
"""Processor time that an entry may take on a track, the simulation included [s of a core]."""


@dataclass(frozen=True)
class Subject(ABC):
    """A body that entries drive.

    Args:
        starts: from how many unseen starts every condition is tried; fewer are for a first look.
    """

    NAME: ClassVar[str]
    CONDITIONS: ClassVar[tuple[str, ...]]
    """The disturbances (`disturbances_named`), beside none."""

    starts: int = 16

    @property
    def disturbances(self) -> tuple[Disturbance, ...]:
        """Disturbances of the track, one condition per level."""
        return disturbances_named(self.CONDITIONS)

    @property
    @abstractmethod
    def senses(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the entries that are observed, by the track."""

    @property
    @abstractmethod
    def commands(self) -> tuple[str, ...]:
        """Names of the action's entries."""

    @property
    @abstractmethod
    def bounds(self) -> np.ndarray:
        """Least and largest action, [2, actions]; values beyond are cut off."""

    @property
    @abstractmethod
    def step_s(self) -> float:
        """Time between two actions [s]."""

    @abstractmethod
    def scores(self, entry: Entry, track: str) -> np.ndarray:
        """Return the score of every episode, [conditions, starts], or NaN of one that ends in a
        fall.

        Raises:
            TegotaeError: for an entry that fails, or needs more than `MOST_CPU_S`.
        """

    def episodes(self, scores: np.ndarray) -> pd.DataFrame:
        """Return one row per episode: `condition`, `level`, `start` and `score`, undefined after a
        fall.
        """
        met = [("none", np.nan), *((x.name, y) for x in self.disturbances for y in x.outwards)]
        rows = [(*met[i], start, score) for (i, start), score in np.ndenumerate(scores)]
        return pd.DataFrame(rows, columns=["condition", "level", "start", "score"])


def of_limbs(names: Sequence[str], limbs: int) -> tuple[str, ...]:
    """Return names limb by limb.

    Example:
        >>> of_limbs(["force"], 1), of_limbs(["force"], 2)
        (('force',), ('force[0]', 'force[1]'))
    """
    return (*names,) if limbs == 1 else tuple(f"{x}[{i}]" for x in names for i in range(limbs))


def summary(scores: np.ndarray) -> dict[str, float]:
    """Return the score of an entry, and the share of its episodes without a fall, with 95 %
    intervals.

    Starts are independent, conditions are not: the bootstrap draws starts, and Wilson's interval
    counts as many trials as there are starts.

    Args:
        scores: of `Subject.scores`, [conditions, starts].

    Returns:
        `score`, the mean, to which a fall contributes 0, with `low` and `high`; `stands`, the share
        without a fall, with `stands_low` and `stands_high`.

    Example:
        >>> scored = summary(np.array([[1.0, np.nan], [1.0, 1.0]]))
        >>> scored["score"], scored["stands"]
        (0.75, 0.75)
    """
    mean = interval(np.nan_to_num(scores).mean(axis=0), within=POSITIVE)
    stands = ~np.isnan(scores)
    standing = share_interval(int(stands.sum()), stands.size, scores.shape[1])
    of_stands = {
        "stands": standing.mean,
        "stands_low": standing.low,
        "stands_high": standing.high,
    }
    return {"score": mean.mean, "low": mean.low, "high": mean.high, **of_stands}


def of_walk(cot_inverse: ArrayLike, speed: ArrayLike, command: float) -> np.ndarray:
    """Return the score of walks, `CoT⁻¹ max(0, 1 - |v / v* - 1|)`; a walk backwards has none.

    Args:
        cot_inverse: m g v / P of each.
        speed: v of each.
        command: v*.

    Example:
        >>> of_walk([4.0, 4.0, 4.0], [0.5, 0.25, 1.5], 0.5).tolist()
        [4.0, 2.0, 0.0]
    """
    follows = np.maximum(0.0, 1.0 - np.abs(np.asarray(speed) / command - 1.0))
    return np.nan_to_num(np.asarray(cot_inverse) * follows)


class Driver:
    """An entry on many episodes side by side, a policy each.

    Args:
        subject: what it drives.
        entry: what drives it.
        lanes: how many episodes.
    """

    def __init__(self, subject: Subject, entry: Entry, lanes: int) -> None:
        self._bounds, self._began_s = subject.bounds, time.process_time()
        self._actions = np.zeros((lanes, len(subject.commands)))
        with other_code("the entry cannot begin an episode"):
            self._policies = [entry() for _ in range(lanes)]

    def __call__(self, observed: np.ndarray, alive: np.ndarray | None = None) -> np.ndarray:
        """Return the actions of all lanes, [lanes, actions].

        Args:
            observed: [lanes, entries].
            alive: which of them go on, [lanes]; the others keep their last action.

        Raises:
            TegotaeError: for an entry that fails, acts by another number of finite numbers, or has
                used up its time.
        """
        if time.process_time() - self._began_s > MOST_CPU_S:
            raise TegotaeError(f"the entry took more than {MOST_CPU_S:g} s of a core")
        lanes = range(len(observed)) if alive is None else np.flatnonzero(alive).tolist()
        shape = self._actions.shape[1:]
        with other_code("the entry failed"):
            for lane in lanes:
                acted = np.asarray(self._policies[lane](observed[lane]), float)
                if acted.shape != shape or not np.isfinite(acted).all():
                    raise TegotaeError(
                        f"it acts by {acted.tolist()} on {observed[lane].tolist()}; "
                        f"an action is {shape[0]} finite numbers, [{shape[0]}]"
                    )
                self._actions[lane] = acted
        return np.clip(self._actions, *self._bounds)
