"""Means, differences and shares over runs, with 95 % intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count

LEVEL = 0.95
"""Coverage of an interval."""

RESAMPLES = 10_000
"""Number of bootstrap samples."""

FEW = 8
"""Below so many values the bootstrap's interval is too narrow, and Student's t is taken instead: of
three values the bootstrap never leaves their range, and covers the mean in about 75 %."""

Range = tuple[float, float]
"""Least and largest possible value."""

UNBOUNDED: Range = (-math.inf, math.inf)
"""Range of an unbounded quantity."""

POSITIVE: Range = (0.0, math.inf)
"""Range of a quantity that is never negative."""

SHARE: Range = (0.0, 1.0)
"""Range of a share."""

_STUDENT = (
    12.706204736174694,
    4.302652729749462,
    3.1824463052837078,
    2.7764451051977934,
    2.5705818356363146,
    2.4469118511449786,
)
"""Student's t of 97.5 % for 1 to `FEW` - 2 degrees of freedom, without SciPy's slow import."""

_ROUNDING = 1e-4
"""Tolerance of a single-precision value beyond the end of its range."""

BOOTSTRAP, STUDENT, WELCH = "bootstrap", "Student's t", "Welch's t"
WILSON = "Wilson's score"
"""Methods of intervals."""


UNDEFINED = "–"
"""Stands for a number that is not defined."""


@dataclass(frozen=True)
class Interval:
    """A mean or a share with its spread and its 95 % interval, in the unit of the values.

    Undefined values (NaN) do not enter, and are counted. Everything is NaN where nothing is left;
    spread and interval are NaN for a single value, which says nothing about them.
    """

    mean: float
    """Mean of the defined values."""
    std: float = math.nan
    """Their standard deviation (n - 1)."""
    low: float = math.nan
    """Lower end of the 95 % interval of the mean."""
    high: float = math.nan
    """Upper end."""
    count: int = 0
    """Number of defined values."""
    undefined: int = 0
    """Number of undefined values."""
    method: str = field(default="", repr=False, compare=False)
    """Method of the interval; empty if there is none."""

    def __str__(self) -> str:
        """Return the mean with the interval as text; a star marks undefined values, a dash that all
        are.

        Example:
            >>> print(Interval(0.4213, low=0.398, high=0.444))
            0.421 [0.398, 0.444]
        """
        if math.isnan(self.mean):
            return UNDEFINED
        mean = f"{self.mean:.3g}{'*' if self.undefined else ''}"
        return mean if math.isnan(self.low) else f"{mean} [{self.low:.3g}, {self.high:.3g}]"


def interval(values: ArrayLike, *, within: Range = UNBOUNDED) -> Interval:
    """Return the mean of independent values, such as one per seed, and its 95 % interval.

    That is the percentile bootstrap's, or Student's t for fewer than `FEW` values. The same values
    give the same interval.

    Student's t knows nothing of the values' range, and of few values it reaches beyond it. The true
    mean is not there, so what reaches beyond is cut off: the rest covers the mean just as often.
    Values that are all alike have an interval of no width; that is no proof that others are too.

    Args:
        values: shape [n]; NaN where undefined.
        within: least and largest possible value, such as 0 and 1 of a share
            (`tegotae.measures.metric.Metric`).

    Raises:
        TegotaeError: for anything but a row of numbers, or a value out of its range.

    Example:
        >>> found = interval([1.0, 2.0, 3.0, float("nan")])
        >>> found.mean, found.count, found.undefined
        (2.0, 3, 1)
        >>> found = interval([1.0, 1.0, 0.6], within=(0.0, 1.0))
        >>> f"{found.low:.2f} {found.high:.2f}"
        '0.29 1.00'
    """
    values = _row("values", values, within)
    defined = values[~np.isnan(values)]
    count, undefined = len(defined), len(values) - len(defined)
    mean = float(defined.mean()) if count else math.nan
    if count < 2:
        return Interval(mean, count=count, undefined=undefined)
    std = float(defined.std(ddof=1))
    if count < FEW:
        half = _STUDENT[count - 2] * std / math.sqrt(count)
        low, high = _clip(mean - half, mean + half, within)
        return Interval(mean, std, low, high, count, undefined, STUDENT)
    low, high = np.quantile(_resampled_means(defined), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(mean, std, float(low), float(high), count, undefined, BOOTSTRAP)


def paired_difference(
    values: ArrayLike, baseline: ArrayLike, *, within: Range = UNBOUNDED
) -> Interval:
    """Return the mean of `values - baseline`, pair by pair (such as the same seed), and its
    interval.

    A pair with an undefined member is undefined.

    Args:
        values: shape [n].
        baseline: of the same runs, shape [n].
        within: least and largest possible value of either; a difference of two shares lies in
            [-1, 1].

    Raises:
        TegotaeError: for rows of different lengths.

    Example:
        >>> paired_difference([2.0, 3.0, 5.0], [1.0, 2.0, 4.0])
        Interval(mean=1.0, std=0.0, low=1.0, high=1.0, count=3, undefined=0)
    """
    values, baseline = _row("values", values, within), _row("baseline", baseline, within)
    if len(values) != len(baseline):
        raise TegotaeError(
            f"{len(values)} values cannot be paired with {len(baseline)}; both rows must be of the "
            "same runs"
        )
    return interval(values - baseline, within=_difference_range(within))


def difference(
    values: ArrayLike,
    baseline: ArrayLike,
    *,
    single_is_exact: bool = False,
    within: Range = UNBOUNDED,
) -> Interval:
    """Return the difference of the means of two independent rows, and its interval (Welch's t).

    `std` is its standard error; `count` and `undefined` are over both rows. A row with a single
    defined value leaves the interval undefined, unless it is exact, and one with none the
    difference, too.

    Args:
        values: one row, NaN where undefined, [count].
        baseline: the other, [count] of its own.
        single_is_exact: as for `stratified_difference`.
        within: least and largest possible value of either.

    Example:
        >>> found = difference([2.0, 2.2, 1.8], [1.0, 1.1, 0.9, 1.0])
        >>> f"{found.mean:.2f}", found.low > 0.0
        ('1.00', True)
    """
    rows = [_row("values", values, within), _row("baseline", baseline, within)]
    if all(_has_mean(row, single_is_exact) for row in rows):
        return balanced_difference(
            rows[:1], rows[1:], single_is_exact=single_is_exact, within=within
        )
    (a, _, n), (b, _, m) = map(_mean_and_error, rows)
    return Interval(a - b, count=n + m, undefined=sum(map(len, rows)) - n - m)


def stratified_difference(
    strata: Iterable[tuple[ArrayLike, ArrayLike]],
    *,
    single_is_exact: bool = False,
    within: Range = UNBOUNDED,
) -> Interval:
    """Return the mean over strata of `mean(values) - mean(baseline)`, and its interval.

    Like is compared with like: where strata differ in level and in how much is undefined, the
    difference of the overall means is that of the mixtures. A stratum is left out if one of its
    rows has no mean with a spread, that is, fewer than two defined values.

    Args:
        strata: pairs of independent rows, values and baseline.
        single_is_exact: whether a row of one value is no sample but exact, such as the outcome of a
            search without randomness.
        within: least and largest possible value of either row, as for `interval`.

    Example:
        >>> found = stratified_difference([([1.0, 1.2], [0.0, 0.2]), ([9.0, 9.2], [8.0, 8.2])])
        >>> f"{found.mean:.2f}"
        '1.00'
    """
    pairs = [(_row("values", values), _row("baseline", base)) for values, base in strata]
    valid = [pair for pair in pairs if all(_has_mean(row, single_is_exact) for row in pair)]
    rows, baselines = [a for a, _ in valid], [b for _, b in valid]
    return balanced_difference(rows, baselines, single_is_exact=single_is_exact, within=within)


def balanced_difference(
    values: Iterable[ArrayLike],
    baseline: Iterable[ArrayLike] = (),
    *,
    single_is_exact: bool = False,
    within: Range = UNBOUNDED,
) -> Interval:
    """Return the mean of the means of some rows, minus that of others, and its interval.

    Rows count alike, however many values they have; those with fewer than two defined ones are left
    out. The interval is Student's t with the degrees of freedom of Welch and Satterthwaite. `std`
    is the standard error; `count` and `undefined` are over the rows that are used.

    Args:
        values: independent rows.
        baseline: rows to subtract; without any, the mean of the first is found.
        single_is_exact: as for `stratified_difference`.
        within: least and largest possible value of every row, as for `interval`.

    Example:
        >>> found = balanced_difference([[1.0, 1.2, 1.1], [9.0, 9.2]])
        >>> f"{found.mean:.2f}"
        '5.10'
    """
    checked = [_row("values", row, within) for row in values]
    baselines = [_row("baseline", row, within) for row in baseline]
    ours, theirs = (
        [row for row in rows if _has_mean(row, single_is_exact)] for rows in (checked, baselines)
    )
    terms = [_mean_and_error(row) for row in (*ours, *theirs)]
    count = sum(n for _, _, n in terms)
    undefined = sum(map(len, (*ours, *theirs))) - count
    if not ours or (baseline and not theirs):
        return Interval(math.nan, count=count, undefined=undefined)
    weights = [1.0 / len(ours)] * len(ours) + [-1.0 / max(len(theirs), 1)] * len(theirs)
    mean = sum(w * m for w, (m, _, _) in zip(weights, terms, strict=True))
    if all(n == 1 for _, _, n in terms):
        return Interval(mean, count=count, undefined=undefined)
    parts = [(w * w * e, n - 1) for w, (_, e, n) in zip(weights, terms, strict=True) if e > 0.0]
    variance = sum(part for part, _ in parts)
    freedom = variance**2 / sum(part**2 / n for part, n in parts) if parts else np.inf
    half = _t(freedom) * math.sqrt(variance)
    possible = _difference_range(within) if baseline else within
    low, high = _clip(mean - half, mean + half, possible)
    return Interval(mean, math.sqrt(variance), low, high, count, undefined, WELCH)


def _has_mean(row: np.ndarray, single_is_exact: bool = False) -> bool:
    """Return whether the mean of a row has a known spread: two defined values, or an exact one."""
    defined = int((~np.isnan(row)).sum())
    return defined >= 2 or (single_is_exact and len(row) == defined == 1)


def _mean_and_error(row: np.ndarray) -> tuple[float, float, int]:
    """Return the mean of the defined values, its variance (0 for a single value), and their
    number.
    """
    defined = row[~np.isnan(row)]
    n = len(defined)
    mean = float(defined.mean()) if n else math.nan
    return mean, float(defined.var(ddof=1)) / n if n > 1 else 0.0, n


def _t(freedom: float) -> float:
    """Return half the width of an interval, in standard errors."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(min(freedom, 1e9), (1.0 + LEVEL) / 2.0))


def _difference_range(within: Range) -> Range:
    """Return the range of the difference of two values, both within the same range."""
    return within[0] - within[1], within[1] - within[0]


def _clip(low: float, high: float, within: Range) -> Range:
    """Return an interval without its impossible part."""
    return max(low, within[0]), min(high, within[1])


def mean_defined(values: np.ndarray) -> np.ndarray:
    """Return the mean of the defined values over the last axis; NaN where there are none."""
    defined = ~np.isnan(values)
    count = defined.sum(axis=-1)
    total = np.where(defined, values, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _resampled_means(values: np.ndarray) -> np.ndarray:
    """Return the means of samples drawn with replacement, [RESAMPLES]."""
    drawn = np.random.default_rng(0).integers(0, len(values), (RESAMPLES, len(values)))
    return values[drawn].mean(axis=1)


def _row(name: str, values: ArrayLike, within: Range = UNBOUNDED) -> np.ndarray:
    try:
        row = np.asarray(values, float)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} must be a row of numbers") from None
    if row.ndim != 1 or np.isinf(row).any():
        raise TegotaeError(f"{name} must be one row of finite numbers, or NaN where undefined")
    outside = row[(row < within[0] - _ROUNDING) | (row > within[1] + _ROUNDING)]
    if len(outside):
        raise TegotaeError(
            f"{name} hold {outside[0]:g}; they must lie between {within[0]:g} and {within[1]:g}"
        )
    return row


_Z = 1.959963984540054
"""The normal quantile of 97.5 %."""


def share_interval(count: int, total: int, runs: int | None = None) -> Interval:
    """Compute a share, `count / total`, and its 95 % interval by Wilson's score; NaN for a total of
    zero.

    Args:
        count: number of trials that have it.
        total: number of trials.
        runs: number of independent runs that the trials belong to, if these are fewer: trials of
            one run count as if all of them did the same.

    Raises:
        TegotaeError: unless 0 <= count <= total.

    Source:
        Wilson, J. American Statistical Association 22 (1927).

    Example:
        >>> print(share_interval(24, 24), share_interval(60, 80, 20))
        1 [0.862, 1] 0.75 [0.531, 0.888]
    """
    require_count("total", total, least=0)
    require_count("count", count, least=0, most=total)
    if total == 0:
        return Interval(math.nan, method=WILSON)
    trials = total if runs is None else runs
    having = count if runs is None else round(count / total * runs)
    share, z2 = having / trials, _Z**2 / trials
    middle = (share + z2 / 2) / (1 + z2)
    half = _Z * math.sqrt(share * (1 - share) / trials + z2 / (4 * trials)) / (1 + z2)
    # Of none, and of all, the ends are 0 and 1, which rounding would miss.
    low, high = middle - half if having else 0.0, middle + half if having < trials else 1.0
    return Interval(count / total, low=low, high=high, count=total, method=WILSON)
