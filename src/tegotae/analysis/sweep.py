"""Rollouts over a grid of two quantities, as one batch."""

from __future__ import annotations

import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_GAIN, MOST_POINTS, require_memory
from tegotae.analysis.outcome import Outcome

MAP_DURATION_S = 40.0
"""Simulated time of every rollout of a map [s], as of the undisturbed part of an evaluation: what
has not settled by its end counts as without limit cycle."""


def axis(
    name: str,
    low: float,
    high: float,
    points: int,
    *,
    above: float | None = None,
    most: float = MOST_GAIN,
) -> np.ndarray:
    """`points` evenly spaced values from `low` to `high`.

    Args:
        name: of the quantity.
        low: the first value.
        high: the last one.
        points: how many values, `MOST_POINTS` at most.
        above: all values must be greater than this.
        most: no value may be larger than this, either way.

    Raises:
        TegotaeError: for values that are not finite or beyond their bounds, an empty range, or
            fewer than two points.
    """
    for end, value in (("low", low), ("high", high)):
        require_finite(f"{name} ({end} end)", value, above=above, least=-most, most=most)
    require_count(f"points along {name}", points, least=2, most=MOST_POINTS)
    if not low < high:
        raise TegotaeError(
            f"{name} goes from {low:g} to {high:g}; the second must be greater than the first"
        )
    return np.linspace(low, high, points)


def lanes(rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every pair of a row's and a column's value, each of shape [rows · columns]."""
    # Each lane is a rollout, whose outcome is some thirty numbers.
    require_memory(256.0 * len(rows) * len(columns), f"{len(rows)} x {len(columns)} rollouts")
    row, column = np.meshgrid(rows, columns, indexing="ij")
    return row.ravel(), column.ravel()


def as_maps(outcome: Outcome, rows: np.ndarray, columns: np.ndarray) -> Outcome:
    """The outcome of lanes as maps, shape [rows, columns]."""
    return Outcome(*(np.reshape(x, (len(rows), len(columns))) for x in outcome))
