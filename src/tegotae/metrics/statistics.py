"""Means over seeds, and how sure they are: the bootstrap, and Student's t for small samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy.special

from tegotae.errors import TegotaeError, require_count

LEVEL = 0.95
"""Coverage of an interval."""

RESAMPLES = 10_000
"""How often a sample is drawn anew."""

FEW = 8
"""Below so many values the bootstrap's interval is too narrow, and Student's t is taken instead: of
three values the bootstrap never leaves their range, and covers the mean in about 75 %."""


@dataclass(frozen=True)
class Interval:
    """A mean with its spread and its 95 % interval, in the unit of the values.

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
    """Mean of independent values, such as one per seed, and its 95 % interval.

    That is the percentile bootstrap's, or Student's t for fewer than `FEW` values.

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
    std = float(defined.std(ddof=1))
    if len(defined) < FEW:
        half = _t(len(defined) - 1) * std / math.sqrt(len(defined))
        return Interval(mean, std, mean - half, mean + half, len(defined), undefined)
    low, high = np.quantile(_resampled_means(defined, seed), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(mean, std, float(low), float(high), len(defined), undefined)


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


def difference(values: Any, baseline: Any) -> Interval:
    """Difference of the means of two independent rows, and its interval (Welch's t).

    `std` is its standard error; `count` and `undefined` are over both rows. A row with a single
    defined value leaves the interval undefined, and one with none the difference, too.

    Example:
        >>> found = difference([2.0, 2.2, 1.8], [1.0, 1.1, 0.9, 1.0])
        >>> f"{found.mean:.2f}", found.low > 0.0
        ('1.00', True)
    """
    rows = [_row("values", values), _row("baseline", baseline)]
    found = balanced_difference(rows[:1], rows[1:])
    if found.count + found.undefined == sum(map(len, rows)):
        return found
    defined = [row[~np.isnan(row)] for row in rows]
    count = sum(map(len, defined))
    mean = float(defined[0].mean() - defined[1].mean()) if all(map(len, defined)) else np.nan
    return Interval(mean, np.nan, np.nan, np.nan, count, sum(map(len, rows)) - count)


def stratified_difference(
    strata: Iterable[tuple[Any, Any]], *, factor: float = 1.0, single_is_exact: bool = False
) -> Interval:
    """Mean over strata of `mean(values) - factor · mean(baseline)`, and its interval.

    Like is compared with like: where strata differ in level and in how much is undefined, the
    difference of the overall means is that of the mixtures. A stratum is left out if one of its
    rows has no mean with a spread, that is, fewer than two defined values.

    Args:
        strata: pairs of independent rows, values and baseline.
        factor: of the baseline.
        single_is_exact: whether a row of one value is no sample but exact, such as the outcome of a
            search without randomness.

    Example:
        >>> found = stratified_difference([([1.0, 1.2], [0.0, 0.2]), ([9.0, 9.2], [8.0, 8.2])])
        >>> f"{found.mean:.2f}"
        '1.00'
    """
    pairs = [(_row("values", values), _row("baseline", base)) for values, base in strata]
    used = [pair for pair in pairs if all(has_mean(row, single_is_exact) for row in pair)]
    rows, baselines = [a for a, _ in used], [b for _, b in used]
    return balanced_difference(rows, baselines, factor=factor, single_is_exact=single_is_exact)


def balanced_difference(
    values: Iterable[Any],
    baseline: Iterable[Any] = (),
    *,
    factor: float = 1.0,
    single_is_exact: bool = False,
) -> Interval:
    """Mean of the means of some rows, minus `factor` times that of others, and its interval.

    Rows count alike, however many values they have; those with fewer than two defined ones are left
    out. The interval is Student's t with the degrees of freedom of Welch and Satterthwaite. `std`
    is the standard error; `count` and `undefined` are over the rows that are used.

    Args:
        values: independent rows.
        baseline: rows to subtract; without any, the mean of the first is found.
        factor: of the baseline.
        single_is_exact: as for `stratified_difference`.

    Example:
        >>> found = balanced_difference([[1.0, 1.2, 1.1], [9.0, 9.2]])
        >>> f"{found.mean:.2f}"
        '5.10'
    """
    sides = [
        [row for row in map(partial(_row, name), rows) if has_mean(row, single_is_exact)]
        for name, rows in (("values", values), ("baseline", baseline))
    ]
    rows = [*sides[0], *sides[1]]
    count = sum(int((~np.isnan(row)).sum()) for row in rows)
    undefined = sum(map(len, rows)) - count
    if not sides[0] or (baseline and not sides[1]):
        return Interval(np.nan, np.nan, np.nan, np.nan, count, undefined)
    weights = [1.0 / len(sides[0])] * len(sides[0]) + [-factor / max(len(sides[1]), 1)] * len(
        sides[1]
    )
    terms = [_mean_and_error(row) for row in rows]
    mean = sum(w * m for w, (m, _, _) in zip(weights, terms, strict=True))
    if all(n == 1 for _, _, n in terms):
        return Interval(mean, np.nan, np.nan, np.nan, count, undefined)
    parts = [(w * w * e, n - 1) for w, (_, e, n) in zip(weights, terms, strict=True) if e > 0.0]
    variance = sum(part for part, _ in parts)
    freedom = variance**2 / sum(part**2 / n for part, n in parts) if parts else np.inf
    half = _t(freedom) * math.sqrt(variance)
    return Interval(mean, math.sqrt(variance), mean - half, mean + half, count, undefined)


def has_mean(row: np.ndarray, single_is_exact: bool = False) -> bool:
    """Whether the mean of a row has a known spread: two defined values, or an exact one."""
    defined = int((~np.isnan(row)).sum())
    return defined >= 2 or (single_is_exact and len(row) == defined == 1)


def _mean_and_error(row: np.ndarray) -> tuple[float, float, int]:
    """Mean of what is defined, its variance (0 for a single value), and how much that is."""
    defined = row[~np.isnan(row)]
    n = len(defined)
    return float(defined.mean()), float(defined.var(ddof=1)) / n if n > 1 else 0.0, n


def _t(freedom: float) -> float:
    """Half the width of an interval, in standard errors."""
    return float(scipy.special.stdtrit(min(freedom, 1e9), (1.0 + LEVEL) / 2.0))


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
