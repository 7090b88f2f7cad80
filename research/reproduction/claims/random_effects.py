"""The interval of a mean over designs and frequencies, both drawn from many like these."""

from __future__ import annotations

import numpy as np
from scipy import stats


def crossed(differences: np.ndarray) -> tuple[float, float]:
    """Return the 95 % interval of the mean of differences [designs, ω_t], both random effects.

    `Var = (MS_design + MS_ω - MS_rest) / (designs · ω_t)`, at least `MS_rest / (designs · ω_t)`;
    degrees of freedom after Satterthwaite. Of one design, or of one ω_t, it is Student's over the
    other; of a single difference it is NaN.

    Example:
        >>> low, high = crossed(np.array([[0.1, 0.3], [0.2, 0.4], [0.15, 0.35]]))
        >>> bool(low < 0.25 < high)
        True
    """
    designs, omegas = differences.shape
    if differences.size < 2:
        return np.nan, np.nan
    if 1 in differences.shape:
        return _student(differences, float(differences.var(ddof=1)), differences.size - 1)
    by_design, by_omega = differences.mean(axis=1), differences.mean(axis=0)
    residuals = differences - by_design[:, None] - by_omega[None] + differences.mean()
    df = np.array([designs - 1, omegas - 1, (designs - 1) * (omegas - 1)])
    squares = np.array(
        [
            omegas * by_design.var(ddof=1),
            designs * by_omega.var(ddof=1),
            (residuals**2).sum() / df[2],
        ]
    )
    total = float(squares @ [1.0, 1.0, -1.0])
    if total > squares[2]:
        return _student(differences, total, total**2 / (squares**2 / df).sum())
    return _student(differences, float(squares[2]), float(df[2]))


def complete(differences: np.ndarray) -> np.ndarray:
    """Return differences without the designs or ω_t that lack numbers; those that lack most are
    removed first.

    Example:
        >>> complete(np.array([[1.0, np.nan], [2.0, 3.0], [4.0, np.nan]])).tolist()
        [[1.0], [2.0], [4.0]]
    """
    while (missing := np.isnan(differences)).any():
        designs, omegas = missing.mean(axis=1), missing.mean(axis=0)
        axis = int(omegas.max() >= designs.max())
        worst = (designs, omegas)[axis].argmax()
        differences = np.delete(differences, worst, axis)
    return differences


def _student(values: np.ndarray, variance: float, freedom: float) -> tuple[float, float]:
    """Return the interval of the mean of values of a variance."""
    half = stats.t.ppf(0.975, freedom) * np.sqrt(variance / values.size)
    return float(values.mean() - half), float(values.mean() + half)
