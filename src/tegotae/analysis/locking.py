"""Which ratio of turns to hops a gait is locked at."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from tegotae.analysis.outcome import Outcome
from tegotae.measures.hopping.gait import LIMIT_CYCLE


def locking_ratios(outcome: Outcome) -> np.ndarray:
    """Turns of the oscillator per hop as fractions p/q in lowest terms; None without limit cycle.

    On a limit cycle of k hops the oscillator makes a whole number of turns, so that p/q is exact:
    the nearest fraction with denominator k.

    Args:
        outcome: arrays of any shape.

    Returns:
        Array of `Fraction` or None, of that shape.
    """
    ratios = np.full(outcome.regime.shape, None, object)
    for at in zip(*np.nonzero(outcome.regime == LIMIT_CYCLE), strict=True):
        k = int(outcome.limit_cycle_period[at])
        ratios[at] = Fraction(round(float(outcome.winding_ratio[at]) * k), k)
    return ratios
