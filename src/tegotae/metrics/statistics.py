"""Means over seeds, and how sure they are: the percentile bootstrap."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tegotae.errors import TegotaeError, require_count

LEVEL = 0.95
"""Coverage of an interval."""

RESAMPLES = 10_000
"""How often a sample is drawn anew."""


@dataclass(frozen=True)
class Interval:
    """A mean with its spread and its bootstrap interval, in the unit of the values.

    Undefined values (NaN) do not enter, and are counted. Everything is NaN where nothing is left;
    spread and interval are NaN for a single value, which says nothing about them.
    """

    mean: float
    """Mean of the defined values."""
    std: float
    """Their standard deviation (n - 1)."""
    low: float
    """Lower end of the 95 % interval of the mean."""
    high: float
    """Upper end."""
    count: int
    """How many values are defined."""
    undefined: int
    """How many are not."""


def interval(values: Any, *, seed: int = 0) -> Interval:
    """Mean of independent values, such as one per seed, and its 95 % percentile bootstrap interval.

    Args:
        values: shape [n]; NaN where undefined.
        seed: of the resampling, so that the same values give the same interval.

    Raises:
        TegotaeError: for anything but a row of numbers.

    Example:
        >>> found = interval([1.0, 2.0, 3.0, float("nan")])
        >>> found.mean, found.count, found.undefined
        (2.0, 3, 1)
    """
    values = _row("values", values)
    defined = values[~np.isnan(values)]
    undefined = len(values) - len(defined)
    if len(defined) == 0:
        return Interval(np.nan, np.nan, np.nan, np.nan, 0, undefined)
    mean = float(defined.mean())
    if len(defined) == 1:
        return Interval(mean, np.nan, np.nan, np.nan, 1, undefined)
    low, high = np.quantile(_resampled_means(defined, seed), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(
        mean, float(defined.std(ddof=1)), float(low), float(high), len(defined), undefined
    )


def paired_difference(values: Any, baseline: Any, *, seed: int = 0) -> Interval:
    """Mean of `values - baseline`, pair by pair (such as the same seed), and its interval.

    A pair with an undefined member is undefined.

    Raises:
        TegotaeError: for rows of different lengths.

    Example:
        >>> paired_difference([2.0, 3.0, 5.0], [1.0, 2.0, 4.0])
        Interval(mean=1.0, std=0.0, low=1.0, high=1.0, count=3, undefined=0)
    """
    values, baseline = _row("values", values), _row("baseline", baseline)
    if len(values) != len(baseline):
        raise TegotaeError(
            f"{len(values)} values cannot be paired with {len(baseline)}; both rows must be of the "
            "same runs"
        )
    return interval(values - baseline, seed=seed)


def difference(values: Any, baseline: Any, *, seed: int = 0) -> Interval:
    """Difference of the means of two independent rows, each resampled by itself, and its interval.

    `std` is that of the resampled difference, its standard error; `count` and `undefined` are over
    both rows.

    Example:
        >>> found = difference([2.0, 2.2, 1.8], [1.0, 1.1, 0.9, 1.0])
        >>> f"{found.mean:.2f}", found.low > 0.0
        ('1.00', True)
    """
    return stratified_difference([(values, baseline)], seed=seed)


def stratified_difference(strata: Iterable[tuple[Any, Any]], *, seed: int = 0) -> Interval:
    """Mean over strata of the difference of means within each, and its interval.

    Like is compared with like: where strata differ in level and in how much is undefined, the
    difference of the overall means is that of the mixtures. Strata count alike; one in which a row
    has nothing defined is left out. `std`, `count` and `undefined` are as in `difference`.

    Args:
        strata: pairs of independent rows, values and baseline.
        seed: of the resampling.

    Example:
        >>> found = stratified_difference([([1.0, 1.2], [0.0, 0.2]), ([9.0], [8.0])])
        >>> f"{found.mean:.2f}"
        '1.00'
    """
    pairs = [(_row("values", values), _row("baseline", base)) for values, base in strata]
    whole = [tuple(row[~np.isnan(row)] for row in pair) for pair in pairs]
    count = sum(len(row) for pair in whole for row in pair)
    undefined = sum(len(row) for pair in pairs for row in pair) - count
    used = [(values, base) for values, base in whole if len(values) and len(base)]
    if not used:
        return Interval(np.nan, np.nan, np.nan, np.nan, count, undefined)
    mean = float(np.mean([values.mean() - base.mean() for values, base in used]))
    if min(len(row) for pair in used for row in pair) == 1:
        return Interval(mean, np.nan, np.nan, np.nan, count, undefined)
    drawn = np.mean(
        [
            _resampled_means(values, seed + 2 * i) - _resampled_means(base, seed + 2 * i + 1)
            for i, (values, base) in enumerate(used)
        ],
        axis=0,
    )
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(mean, float(drawn.std(ddof=1)), float(low), float(high), count, undefined)


def mean_defined(values: np.ndarray) -> np.ndarray:
    """Mean over the last axis of what is defined; NaN where nothing is."""
    defined = ~np.isnan(values)
    count = defined.sum(axis=-1)
    total = np.where(defined, values, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _resampled_means(values: np.ndarray, seed: int) -> np.ndarray:
    """Means of samples drawn with replacement, [RESAMPLES]."""
    require_count("seed", seed, least=0)
    drawn = np.random.default_rng(seed).integers(0, len(values), (RESAMPLES, len(values)))
    return values[drawn].mean(axis=1)


def _row(name: str, values: Any) -> np.ndarray:
    try:
        row = np.asarray(values, float)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} must be a row of numbers") from None
    if row.ndim != 1 or np.isinf(row).any():
        raise TegotaeError(f"{name} must be one row of finite numbers, or NaN where undefined")
    return row
