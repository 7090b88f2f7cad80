"""How a map over gain and frequency falls off: best frequencies, and what is lost beside them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tegotae.measures.hopping.statistics import mean_defined
from tegotae.parts._shapes import AnyArray

AWAY_RAD_PER_S = 1.0
"""How far from a frequency its loss is measured [rad/s]."""


class Resonance(NamedTuple):
    """The best frequency per gain, of the gains that have one."""

    sigma: np.ndarray
    """Gains σ [rad/(s N)], shape [points]."""
    omega: np.ndarray
    """Best frequency ω [rad/s], shape [points]."""
    value: np.ndarray
    """The map's value there [m/J], shape [points]."""


class DetuningLoss(NamedTuple):
    """What is lost beside a frequency, at the gain that is best there."""

    omega: np.ndarray
    """Frequencies ω that have a best gain [rad/s], shape [points]."""
    sigma: np.ndarray
    """Best gain σ [rad/(s N)], shape [points]."""
    lost: np.ndarray
    """Share of the map's value that is lost at a lower and at a higher ω, their mean, shape
    [points]; negative where there is more."""


def find_resonance(sigma: np.ndarray, omega: np.ndarray, value: AnyArray) -> Resonance:
    """Where a map is highest along ω, for each σ.

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
    found = np.isfinite(counts[row, best])
    return Resonance(
        np.asarray(sigma)[found], np.asarray(omega)[best][found], counts[row, best][found]
    )


def find_losses(sigma: np.ndarray, omega: np.ndarray, value: AnyArray) -> DetuningLoss:
    """The share of a map that is lost `AWAY_RAD_PER_S` from each ω, at the σ that is best there.

    It is the mean of both sides, where both are inside the map. What has no value has lost all of
    it. Between frequencies of the map values are interpolated.

    Args:
        sigma: gains, shape [gains].
        omega: frequencies in rising order, shape [frequencies].
        value: the map, shape [gains, frequencies]; NaN counts as zero.

    Example:
        >>> omega = np.linspace(2.0, 6.0, 5)
        >>> found = find_losses(np.zeros(1), omega, np.array([[0.0, 1.0, 2.0, 1.0, 0.0]]))
        >>> found.omega, found.lost
        (array([3., 4., 5.]), array([0. , 0.5, 0. ]))
    """
    known = np.where(np.isfinite(value), np.maximum(value, 0.0), 0.0)
    omega = np.asarray(omega, float)
    best = known.argmax(axis=0)
    at = np.flatnonzero(known[best, np.arange(len(omega))] > 0.0)
    losses = []
    for i in at:
        row = known[best[i]]
        sides = omega[i] + np.array([-AWAY_RAD_PER_S, AWAY_RAD_PER_S])
        there = np.interp(sides, omega, row, left=np.nan, right=np.nan)
        losses.append(1.0 - mean_defined(there) / row[i])
    return DetuningLoss(omega[at], np.asarray(sigma, float)[best[at]], np.array(losses, float))
