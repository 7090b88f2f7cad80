"""Dependence of a run's hop rate on the prescribed frequency, over the episodes of its
evaluation."""

from __future__ import annotations

import numpy as np

from tegotae.measures.optimum import curve
from tegotae.measures.statistics import mean_defined

_FEWEST = 3
"""A slope needs so many settled episodes."""


def rate_slope(omega: np.ndarray, hop_rate: np.ndarray) -> np.ndarray:
    """Return the slope of the line of hop rate over ω, [runs]: 1 for gaits that follow the
    oscillator.

    Args:
        omega: prescribed frequencies [rad/s], [episodes]; NaN without an oscillator.
        hop_rate: the hop rates [rad/s], [runs, episodes]; NaN where undefined.

    Returns:
        NaN for runs in which fewer than three episodes define it.

    Example:
        >>> rate_slope(np.array([3.0, 4.0, 5.0]), np.array([[3.5, 4.0, 4.5]]))
        array([0.5])
    """
    defined = np.isfinite(hop_rate) & np.isfinite(omega)
    number = defined.sum(axis=1)
    rows = np.maximum(number, 1)[:, None]

    def centred(values: np.ndarray) -> np.ndarray:
        values = np.where(defined, values, 0.0)
        return np.where(defined, values - values.sum(axis=1, keepdims=True) / rows, 0.0)

    x, y = centred(np.broadcast_to(omega, hop_rate.shape)), centred(hop_rate)
    enough = number >= _FEWEST
    return np.where(
        enough, (x * y).sum(axis=1) / np.where(enough, (x * x).sum(axis=1), 1.0), np.nan
    )


def nearer_resonance(omega: np.ndarray, hop_rate: np.ndarray) -> np.ndarray:
    """Return the distance of the hop rate from ω minus that from the best one of the body [rad/s],
    [runs].

    The body's best hop rate is that of the largest CoT⁻¹ which any force can have; the mean is over
    the episodes that settle.

    Args:
        omega: prescribed frequencies [rad/s], [episodes]; NaN without an oscillator.
        hop_rate: the hop rates [rad/s], [runs, episodes]; NaN where undefined.

    Example:
        >>> best = best_hop_rate()
        >>> nearer_resonance(np.array([best + 2.0]), np.array([[best]])).round(3)
        array([2.])
    """
    gap = np.abs(hop_rate - omega) - np.abs(hop_rate - best_hop_rate())
    return np.asarray(mean_defined(gap))


def best_hop_rate() -> float:
    """Return the hop rate of the most efficient gait that the default hopper can have [rad/s]."""
    optimum = curve()
    return float(optimum["omega"][np.nanargmax(optimum["cot_inverse"])])
