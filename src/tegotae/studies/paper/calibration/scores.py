"""What the paper says of V and of Fig. 4 as scores: 1 agrees, 0 does not, and all between."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tegotae.studies.analysis.ridge import find_ridge


class VanillaScores(NamedTuple):
    """How well each statement is met, from 0 to 1; NaN where nothing can be said."""

    settles: float
    """Share of V's episodes with a limit cycle."""
    short_t0: float
    """1 less the mean T0 over the episode, unsettled ones as long as it."""
    short_t1: float
    """The same of T1."""
    dependent: float
    """CPGu."""
    slows: float
    """By which share of ω feedback slows the oscillator while the actuator pushes."""
    sector_line: float
    """Share of the variance of the sector's best σ over ω that a rising line explains."""
    reflex_stays: float
    """1 less the spread of the reflex's best ω over σ, in shares of what it would be by chance."""
    quick_loss: float
    """Share of CoT⁻¹ that is lost 1 rad/s away at the σ that is best at an ω."""


SCORES = VanillaScores._fields


def sector_line(sigma: np.ndarray, omega: np.ndarray, cot: np.ndarray) -> float:
    """How well a rising line explains the best gain over the frequency.

    Args:
        sigma: gains, [gains].
        omega: frequencies [rad/s], [frequencies].
        cot: CoT⁻¹, [gains, frequencies]; NaN without a limit cycle.
    """
    ridge = find_ridge(sigma, omega, cot)
    if not np.isfinite(ridge.r_squared):
        return math.nan
    return float(ridge.r_squared) if ridge.slope > 0.0 else 0.0


def reflex_stays(omega: np.ndarray, cot: np.ndarray) -> float:
    """How little the best frequency moves with the gain; of chance it would be spread evenly."""
    known = np.where(np.isfinite(cot) & (cot > 0.0), cot, -np.inf)
    has = np.isfinite(known).any(axis=1)
    if has.sum() < 3:
        return math.nan
    best = omega[known[has].argmax(axis=1)]
    by_chance = float(np.std(omega))
    return max(0.0, 1.0 - float(np.std(best)) / by_chance)


def quick_loss(omega: np.ndarray, cot: np.ndarray, away: float = 1.0) -> float:
    """The share of CoT⁻¹ that is lost `away` [rad/s] from an ω at the σ that is best there.

    A frequency without a limit cycle has lost all of it.
    """
    value = np.where(np.isfinite(cot), np.maximum(cot, 0.0), 0.0)
    losses = []
    for i in range(len(omega)):
        best = int(value[:, i].argmax())
        here = value[best, i]
        if here <= 0.0:
            continue
        for target in (omega[i] - away, omega[i] + away):
            if omega[0] <= target <= omega[-1]:
                there = float(np.interp(target, omega, value[best]))
                losses.append(max(0.0, 1.0 - there / here))
    return float(np.mean(losses)) if losses else math.nan


def robust_gain(sigma: np.ndarray, omega: np.ndarray, cot: np.ndarray, omega_t: float) -> float:
    """V's gain: that of most CoT⁻¹ over the frequencies of the evaluation, unsettled ones as zero.

    Fig. 4's best gain is another at each ω; one that serves all is what V has.
    """
    near = np.abs(omega - omega_t) <= 2.0 + 1e-9
    value = np.where(np.isfinite(cot[:, near]), np.maximum(cot[:, near], 0.0), 0.0)
    return float(sigma[int(value.mean(axis=1).argmax())])


def short(transient_s: np.ndarray, longest_s: float) -> float:
    """1 less the mean of transients over the longest; NaN ones are as long as that."""
    filled = np.where(np.isfinite(transient_s), transient_s, longest_s)
    return float(np.clip(1.0 - filled.mean() / longest_s, 0.0, 1.0))


def slows(feedback: np.ndarray, force: np.ndarray, omega: np.ndarray) -> float:
    """The mean share of ω by which feedback slows the oscillator while the actuator pushes.

    Args:
        feedback: [rad/s], [frames, lanes].
        force: [N], [frames, lanes].
        omega: [rad/s], [lanes].
    """
    pushes = force > 0.0
    if not pushes.any():
        return math.nan
    share = np.clip(-feedback / omega, 0.0, 1.0)
    return float(share[pushes].mean())
