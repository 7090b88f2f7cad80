"""CoT⁻¹ over gain and frequency: the ridge of the best gains, and the resonance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tegotae.analysis.maps import GainSweep
from tegotae.measures.statistics import mean_defined
from tegotae.parts._shapes import AnyArray

AWAY_RAD_PER_S = 1.0
"""Distance from a frequency at which its loss is measured [rad/s]."""


class Resonance(NamedTuple):
    """The best frequency per gain, of the gains that have one."""

    sigma: np.ndarray
    """Gains σ [rad/(s N)], shape [points]."""
    omega: np.ndarray
    """Best frequency ω [rad/s], shape [points]."""
    value: np.ndarray
    """The map's value there [m/J], shape [points]."""


class DetuningLoss(NamedTuple):
    """Loss beside a frequency, at the gain that is best there."""

    omega: np.ndarray
    """Frequencies ω that have a best gain [rad/s], shape [points]."""
    sigma: np.ndarray
    """Best gain σ [rad/(s N)], shape [points]."""
    loss: np.ndarray
    """Share of the map's value that is lost at a lower and at a higher ω, their mean, shape
    [points]; negative where there is more."""


def find_resonance(sigma: np.ndarray, omega: np.ndarray, value: AnyArray) -> Resonance:
    """Find the maximum of a map along ω, for each σ.

    Args:
        sigma: gains, shape [gains].
        omega: frequencies, shape [frequencies].
        value: the map, shape [gains, frequencies]; NaN, and values that are not positive, do not
            count. Gains without any other value have no best frequency.

    Example:
        >>> omega = np.linspace(2.0, 6.0, 5)
        >>> hill = np.exp(-((omega - 4.0) ** 2)) * np.ones((3, 1))
        >>> find_resonance(np.arange(3.0), omega, hill).omega
        array([4., 4., 4.])
    """
    counts = np.where(np.isfinite(value) & (value > 0.0), value, -np.inf)
    best, row = np.argmax(counts, axis=1), np.arange(len(sigma))
    defined = np.isfinite(counts[row, best])
    return Resonance(
        np.asarray(sigma)[defined], np.asarray(omega)[best][defined], counts[row, best][defined]
    )


def find_losses(sigma: np.ndarray, omega: np.ndarray, value: AnyArray) -> DetuningLoss:
    """Return the share of a map that is lost `AWAY_RAD_PER_S` from each ω, at the σ that is best
    there.

    It is the mean of both sides, where both are inside the map. What has no value has lost all of
    it. Between frequencies of the map values are interpolated.

    Args:
        sigma: gains, shape [gains].
        omega: frequencies in rising order, shape [frequencies].
        value: the map, shape [gains, frequencies]; NaN counts as zero.

    Example:
        >>> omega = np.linspace(2.0, 6.0, 5)
        >>> found = find_losses(np.zeros(1), omega, np.array([[0.0, 1.0, 2.0, 1.0, 0.0]]))
        >>> found.omega, found.loss
        (array([3., 4., 5.]), array([0. , 0.5, 0. ]))
    """
    positive = np.where(np.isfinite(value), np.maximum(value, 0.0), 0.0)
    omega = np.asarray(omega, float)
    best = positive.argmax(axis=0)
    columns = np.flatnonzero(positive[best, np.arange(len(omega))] > 0.0)
    losses = []
    for i in columns:
        row = positive[best[i]]
        sides = omega[i] + np.array([-AWAY_RAD_PER_S, AWAY_RAD_PER_S])
        neighbours = np.interp(sides, omega, row, left=np.nan, right=np.nan)
        losses.append(1.0 - mean_defined(neighbours) / row[i])
    return DetuningLoss(
        omega[columns], np.asarray(sigma, float)[best[columns]], np.array(losses, float)
    )


_RESAMPLES = 2000
_WINDING_TOLERANCE = 0.02


class Ridge(NamedTuple):
    """The best gain per frequency, and the least-squares line `σ = intercept + slope ω`.

    A best gain at the edge of the searched range is censored: beyond may lie a better one. It is
    kept and marked, and the line is that of the others.
    """

    omega: np.ndarray
    """Frequencies that have a best gain ω [rad/s], shape [points]."""
    sigma: np.ndarray
    """Best gain σ [rad/(s N)], shape [points]."""
    value: np.ndarray
    """CoT⁻¹ there [m/J], shape [points]."""
    censored: np.ndarray
    """True where it is the least or the largest gain that was searched, shape [points]."""
    slope: float
    """Slope of the line [1/N]; NaN with fewer than three points that are not censored."""
    slope_error: float
    """Its standard error [1/N]."""
    intercept: float
    """Intercept [rad/(s N)]."""
    r_squared: float
    """Share of the fitted gains' variance that the line explains, R²; NaN if there is none."""
    r_squared_interval: tuple[float, float]
    """Its 95 % percentile bootstrap interval over the frequencies."""

    def line(self, omega: np.ndarray) -> np.ndarray:
        """Return the line's gain at these frequencies."""
        return self.intercept + self.slope * np.asarray(omega)


def find_ridge(sigma: np.ndarray, omega: np.ndarray, value: AnyArray) -> Ridge:
    """Find the maximum of a map along σ, for each ω, and the least-squares line through it.

    Best gains at the edge of the map are censored, and not fitted.

    Args:
        sigma: gains in rising order, shape [gains].
        omega: frequencies, shape [frequencies].
        value: the map, shape [gains, frequencies]; NaN, and values that are not positive, do not
            count. Frequencies without any other value have no best gain.

    Example:
        >>> omega, sigma = np.linspace(2, 6, 5), np.linspace(0, 4, 41)
        >>> hill = np.exp(-(sigma[:, None] - (0.5 * omega + 0.2)) ** 2)
        >>> found = find_ridge(sigma, omega, hill)
        >>> f"{found.slope:.2f} {found.intercept:.2f} {found.r_squared:.2f}"
        '0.50 0.20 1.00'
    """
    counts = np.where(np.isfinite(value) & (value > 0.0), value, -np.inf)
    best = np.argmax(counts, axis=0)
    column = np.arange(len(omega))
    exists = np.isfinite(counts[best, column])
    best, column = best[exists], column[exists]
    points = (
        np.asarray(omega, float)[column],
        np.asarray(sigma, float)[best],
        np.asarray(value, float)[best, column],
    )
    censored = (best == 0) | (best == len(sigma) - 1)
    x, y = points[0][~censored], points[1][~censored]
    if len(x) < 3:
        return Ridge(*points, censored, np.nan, np.nan, np.nan, np.nan, (np.nan, np.nan))
    slope, intercept, r_squared = line(x, y)
    residual = np.sum((y - intercept - slope * x) ** 2)
    error = np.sqrt(residual / (len(x) - 2) / np.sum((x - x.mean()) ** 2))
    draws = np.random.default_rng(0).integers(len(x), size=(_RESAMPLES, len(x)))
    resampled = line(x[draws], y[draws])[2]
    low, high = (
        np.nanquantile(resampled, (0.025, 0.975)) if r_squared == r_squared else 2 * [np.nan]
    )
    return Ridge(
        *points,
        censored,
        float(slope),
        float(error),
        float(intercept),
        float(r_squared),
        (float(low), float(high)),
    )


def line(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return slope, intercept and R² of the least-squares line, along the last axis."""
    dx, dy = x - x.mean(axis=-1, keepdims=True), y - y.mean(axis=-1, keepdims=True)
    xx, xy, yy = (np.sum(a * b, axis=-1) for a, b in ((dx, dx), (dx, dy), (dy, dy)))
    slope = np.divide(xy, xx, out=np.full(np.shape(xx), np.nan), where=xx > 0.0)
    intercept = y.mean(axis=-1) - slope * x.mean(axis=-1)
    return (
        slope,
        intercept,
        np.divide(slope * xy, yy, out=np.full(np.shape(yy), np.nan), where=yy > 0.0),
    )


def one_to_one_ridge(sweep: GainSweep) -> Ridge:
    """Return the ridge of CoT⁻¹ A among the gaits in which the oscillator turns once per hop.

    Other lockings, such as two turns a hop, have ridges of their own: a line through several of
    them at once would measure at which ω one overtakes the other.
    """
    outcome = sweep.outcome
    is_one_to_one = np.abs(outcome.winding_ratio - 1.0) < _WINDING_TOLERANCE
    value = np.where(is_one_to_one, outcome.cot_inverse, np.nan)
    return find_ridge(sweep.sigma, sweep.omega, value)
