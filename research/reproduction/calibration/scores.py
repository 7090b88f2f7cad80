"""Scores of the paper's statements on V and on Fig. 4: 1 agrees, 0 does not, and all between."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from research.reproduction.ridge import find_ridge


class VanillaScores(NamedTuple):
    """Agreement with each statement, from 0 to 1; NaN where it is undefined.

    No threshold is in them: from where on a statement counts as met is asked of the scores later
    (`research.reproduction.calibration.posterior`).
    """

    settles: float
    """Share of V's episodes with a limit cycle."""
    short_t0: float
    """1 less the mean T0 over the episode, unsettled ones as long as it."""
    short_t1: float
    """The same of T1."""
    dependent: float
    """CPGu."""
    slows: float
    """Share of ω by which feedback slows the oscillator while the actuator pushes."""
    sector_line: float
    """Share of the variance of the sector's best σ over ω that a rising line explains, times the
    share of the frequencies that have a best σ."""
    reflex_stays: float
    """1 less the spread of the reflex's best ω over σ, in shares of what it would be by chance,
    times the share of the gains that have a best ω."""
    quick_loss: float
    """Share of CoT⁻¹ that is lost 1 rad/s away at the σ that is best at an ω."""


SCORES = VanillaScores._fields

EVALUATED_AS = {
    "short_t0": "v-t0",
    "short_t1": "v-t1",
    "dependent": "v-cpgu",
    "slows": "v-slows-while-pushing",
    "sector_line": "map-sector-line",
    "reflex_stays": "map-reflex-resonance",
    "quick_loss": "map-quick-loss",
}
"""The claim of the paper that a score is about; there is none that V settles. A body that the
scores chose is no test of these."""


def sector_line(sigma: np.ndarray, omega: np.ndarray, cot: np.ndarray) -> float:
    """Return the fit of a rising line to the best gain over the frequency.

    Frequencies at which nothing hops, or whose best gain is at the map's edge, show no line.

    Args:
        sigma: gains, [gains].
        omega: frequencies [rad/s], [frequencies].
        cot: CoT⁻¹, [gains, frequencies]; NaN without a limit cycle.
    """
    ridge = find_ridge(sigma, omega, cot)
    if not (np.isfinite(ridge.r_squared) and ridge.slope > 0.0):
        return 0.0
    return float(ridge.r_squared) * float((~ridge.censored).sum()) / len(omega)


def reflex_stays(omega: np.ndarray, cot: np.ndarray) -> float:
    """Return the constancy of the best frequency under the gain; by chance it would be spread
    evenly.

    Gains with which nothing hops show no resonance.
    """
    hopping = np.where(np.isfinite(cot) & (cot > 0.0), cot, -np.inf)
    has = np.isfinite(hopping).any(axis=1)
    if has.sum() < 3:
        return 0.0
    best = omega[hopping[has].argmax(axis=1)]
    by_chance = float(np.std(omega))
    return max(0.0, 1.0 - float(np.std(best)) / by_chance) * float(has.mean())


def quick_loss(omega: np.ndarray, cot: np.ndarray, away: float = 1.0) -> float:
    """Return the share of CoT⁻¹ that is lost `away` [rad/s] from an ω at the σ that is best there.

    A frequency without a limit cycle has lost all of it.
    """
    value = np.where(np.isfinite(cot), np.maximum(cot, 0.0), 0.0)
    losses = []
    for i in range(len(omega)):
        best = int(value[:, i].argmax())
        reference = value[best, i]
        if reference <= 0.0:
            continue
        for target in (omega[i] - away, omega[i] + away):
            if omega[0] <= target <= omega[-1]:
                detuned = float(np.interp(target, omega, value[best]))
                losses.append(max(0.0, 1.0 - detuned / reference))
    return float(np.mean(losses)) if losses else math.nan


def tuned_gain(
    sigma: np.ndarray, omega: np.ndarray, fitness: np.ndarray, over: Sequence[float]
) -> float:
    """Return V's gain with the largest mean fitness over some frequencies.

    Fig. 4's best gain is another at each ω. V has one for all that it is evaluated at, and may have
    been tuned at ω_t alone or, which is more robust, over all of them.

    Args:
        sigma: gains, [gains].
        omega: frequencies of the map [rad/s], [frequencies].
        fitness: of the map, [gains, frequencies].
        over: the frequencies that count [rad/s]; the nearest of the map is taken for each.
    """
    columns = [int(np.abs(omega - frequency).argmin()) for frequency in over]
    return float(sigma[int(fitness[:, columns].mean(axis=1).argmax())])


def transient_score(transient_s: np.ndarray, longest_s: float) -> float:
    """Return 1 less the mean of transients over the longest; a NaN counts as the longest."""
    filled = np.where(np.isfinite(transient_s), transient_s, longest_s)
    return float(np.clip(1.0 - filled.mean() / longest_s, 0.0, 1.0))


def slows(feedback: np.ndarray, force: np.ndarray, omega: np.ndarray) -> float:
    """Return the mean share of ω by which feedback slows the oscillator while the actuator pushes.

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
