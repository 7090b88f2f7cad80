"""Influence of choices on a claim: rank correlations with the claim's margin, over the readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from research.reproduction.calibration.prior import PRIOR
from research.reproduction.claims.findings import Finding
from research.reproduction.readings.readings import AnalysisChoice, Reading
from research.reproduction.readings.verdicts import claim_margin

SIGNIFICANT = 0.05
"""A choice decides a claim only if chance alone gives so strong a correlation more rarely."""

_FEWEST = 6
_PERMUTATIONS = 20_000


@dataclass(frozen=True)
class Influence:
    """Influence of a choice on a claim.

    Args:
        choice: what is chosen.
        correlation: Spearman's rank correlation of the choice with the claim's margin: positive if
            more of it (as its values are ordered) is better for the claim. NaN if undefined.
        p: how often, with the margins shuffled over the readings, any choice at all correlates as
            strongly: it allows for looking at all of them.
    """

    choice: AnalysisChoice
    correlation: float
    p: float


def influences(readings: Sequence[Reading], findings: Mapping[int, Finding]) -> list[Influence]:
    """Return the influence of each choice on a claim's margin (`verdicts.claim_margin`).

    Readings in which the margin is undefined are left out. A rank correlation sees what grows or
    falls with a choice, not what is best in its middle.

    Args:
        readings: all readings.
        findings: what comes of the claim, by the number of the reading.
    """
    margins = {number: claim_margin(finding) for number, finding in findings.items()}
    numbers = [number for number, value in margins.items() if not np.isnan(value)]
    codes = np.array(
        [[c.place(getattr(readings[n], c.name)) for n in numbers] for c in PRIOR], float
    )
    values = np.array([margins[n] for n in numbers])
    if len(numbers) < _FEWEST or np.ptp(values) == 0.0:
        return [Influence(choice, np.nan, np.nan) for choice in PRIOR]
    x, y = _standard_ranks(codes), _standard_ranks(values[None])[0]
    correlations = x @ y
    shuffled = np.random.default_rng(0).permuted(np.tile(y, (_PERMUTATIONS, 1)), axis=1)
    strongest = np.abs(shuffled @ x.T).max(axis=1)
    return [
        Influence(
            choice,
            float(rho) if x[i].any() else np.nan,
            float((1 + (strongest >= abs(rho) - 1e-12).sum()) / (1 + _PERMUTATIONS)),
        )
        for i, (choice, rho) in enumerate(zip(PRIOR, correlations, strict=True))
    ]


def decisive(candidates: Sequence[Influence]) -> list[Influence]:
    """Return the choices that correlate with the claim beyond chance, the strongest first."""
    clear = [i for i in candidates if i.p < SIGNIFICANT and not np.isnan(i.correlation)]
    return sorted(clear, key=lambda i: -abs(i.correlation))


def _standard_ranks(rows: np.ndarray) -> np.ndarray:
    """Return the ranks along each row, ties averaged, of mean zero and length one; zero for
    constant rows.
    """
    below = (rows[:, None, :] < rows[:, :, None]).sum(axis=2)
    ties = (rows[:, None, :] == rows[:, :, None]).sum(axis=2)
    ranks = below + 0.5 * (ties - 1)
    ranks = ranks - ranks.mean(axis=1, keepdims=True)
    length = np.sqrt((ranks**2).sum(axis=1, keepdims=True))
    return np.where(length > 0.0, ranks / np.where(length > 0.0, length, 1.0), 0.0)
