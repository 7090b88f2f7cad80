"""Rollouts over a grid of two quantities, as one batch."""

from __future__ import annotations

from typing import Any

import numpy as np

from tegotae.errors import TegotaeError, require_count, require_finite

MAP_DURATION_S = 40.0
"""Simulated time of every rollout of a map [s], as of the undisturbed part of an evaluation: what
has not settled by its end counts as without limit cycle."""


def axis(name: str, low: float, high: float, points: int) -> np.ndarray:
    """`points` evenly spaced values from `low` to `high`.

    Raises:
        TegotaeError: for values that are not finite, an empty range, or fewer than two points.
    """
    require_finite(f"{name} (low end)", low)
    require_finite(f"{name} (high end)", high)
    require_count(f"points along {name}", points, least=2)
    if not low < high:
        raise TegotaeError(
            f"{name} goes from {low:g} to {high:g}; the second must be greater than the first"
        )
    return np.linspace(low, high, points)


def lanes(rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every pair of a row's and a column's value, each of shape [rows · columns]."""
    row, column = np.meshgrid(rows, columns, indexing="ij")
    return row.ravel(), column.ravel()


def as_maps(outcome: Any, rows: np.ndarray, columns: np.ndarray) -> Any:
    """A NamedTuple of lanes as the same NamedTuple of maps, shape [rows, columns]."""
    return type(outcome)(*(np.reshape(x, (len(rows), len(columns))) for x in outcome))
