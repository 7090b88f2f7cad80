"""Footfalls: when each foot is on the ground."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class StanceInterval(NamedTuple):
    """A stance of one leg: from touchdown to liftoff [s]."""

    touchdown_s: float
    liftoff_s: float


def stances(time_s: ArrayLike, stance_time_s: ArrayLike) -> tuple[tuple[StanceInterval, ...], ...]:
    """The stances of every leg of one lane, from the total of its time in stance.

    Touchdown and liftoff are placed within their frames by how much of these was spent in stance.
    A stance that begins before the recording begins with it, and one that goes on ends with it.

    Args:
        time_s: ends of the frames, [frames].
        stance_time_s: total time in stance up to there [s], [frames, limbs].

    Returns:
        A row of stances a leg.

    Example:
        >>> total = np.array([[0.0], [0.1], [0.2], [0.2]])
        >>> stances(np.array([0.1, 0.2, 0.3, 0.4]), total)
        ((StanceInterval(touchdown_s=0.1, liftoff_s=0.3),),)
    """
    time, total = np.asarray(time_s, float), np.asarray(stance_time_s, float)
    starts = np.concatenate([[2.0 * time[0] - time[1]], time[:-1]])
    gained = np.diff(total, axis=0, prepend=np.zeros((1, total.shape[1])))
    return tuple(_of_leg(starts, time, gained[:, leg]) for leg in range(total.shape[1]))


_NOTHING = 1e-3
"""Share of a frame below which there was no stance: the rounding of a float32 total."""


def _of_leg(start: np.ndarray, end: np.ndarray, gained: np.ndarray) -> tuple[StanceInterval, ...]:
    length = end - start
    on = gained > _NOTHING * length
    edges = np.diff(np.concatenate([[False], on, [False]]).astype(int))
    found = []
    for first, after in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        last = after - 1
        if first == last:
            touchdown, liftoff = end[first] - gained[first], end[first]
        else:
            touchdown = end[first] - min(gained[first], length[first])
            liftoff = start[last] + min(gained[last], length[last])
        found.append(StanceInterval(round(float(touchdown), 6), round(float(liftoff), 6)))
    return tuple(found)
