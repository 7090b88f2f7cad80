"""What a claim is made of, and how it is judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae.measures.hopping.statistics import Interval

HOLDS, FAILS, UNDECIDED, NOT_MEASURED = "holds", "fails", "undecided", "not measured"
INFORMATION = ""
"""What is not claimed, and helps to read what is."""


@dataclass(frozen=True)
class Part:
    """One measurable part of a claim.

    Args:
        what: what is measured, with its unit.
        effect: the measured effect with its interval.
        low: the effect must lie above this ...
        high: ... and below this.
        unit: what the interval is over: "runs", "models" or "frequencies".
        without_cycle: how many of these have no limit cycle in any episode; None where that is
            no question.
        least: so many of these must define the effect for it to be measured at all.
    """

    what: str
    effect: Interval
    low: float = -np.inf
    high: float = np.inf
    unit: str = "runs"
    without_cycle: int | None = None
    least: int = 0

    @property
    def n(self) -> int:
        """How many runs (or models, or frequencies) are behind it, defined or not."""
        return self.effect.count + self.effect.undefined

    @property
    def verdict(self) -> str:
        """Whether the interval lies inside the bounds, outside, or across one.

        An effect that no run is behind is not measured; one that no run defines is undecided.
        """
        e = self.effect
        if self.low == -np.inf and self.high == np.inf:
            return INFORMATION
        if self.n == 0 or e.count < self.least:
            return NOT_MEASURED
        if np.isnan([e.low, e.high, self.low, self.high]).any():
            return UNDECIDED
        if self.low <= e.low and e.high <= self.high:
            return HOLDS
        if e.high < self.low or e.low > self.high:
            return FAILS
        return UNDECIDED


@dataclass(frozen=True)
class Verdict:
    """A claim and what the results say about it; without parts or data it is not measured."""

    number: int
    claim: str
    parts: tuple[Part, ...]
    note: str = ""

    @property
    def verdict(self) -> str:
        """holds, fails, undecided, or not measured."""
        each = [part.verdict for part in self.parts if part.verdict != INFORMATION]
        if all(verdict == NOT_MEASURED for verdict in each):
            return NOT_MEASURED
        if FAILS in each:
            return FAILS
        return HOLDS if all(v == HOLDS for v in each) else UNDECIDED
