"""How often a claim holds over the readings, and by how much."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from tegotae.studies.paper.claims import (
    FAILS,
    HOLDS,
    INFORMATION,
    UNDECIDED,
    Part,
    Verdict,
)
from tegotae.studies.paper.claims.slices import verdicts_by_omega
from tegotae.studies.paper.table import Table

CLAIMS = {
    2: "VG far above V, slower",
    3: "VT near V, smoother",
    4: "AR above V, quicker than VG",
    5: "ART above AR",
    6: "ARG below V, ARGT below ART",
    7: "T fails on F, equals ART on Fv",
    8: "ẏ: less CPGu, above, less stable",
    9: "efficient is slow, CPGu quick",
}
"""The claims in few words."""

_Z = 1.959964
"""Half the width of a 95 % interval, in standard errors of a normal variable."""

VerdictsByReading = Mapping[int, Mapping[str, list[Verdict]]]
"""Verdicts by the number of the reading, and then by ω_t: "all", "4", "8"."""


def verdicts_by_reading(tables: Mapping[int, Table]) -> VerdictsByReading:
    """The verdicts under each reading, on all ω_t and at each alone.

    Args:
        tables: the runs by the number of the reading.
    """
    return {number: verdicts_by_omega(table) for number, table in tables.items()}


def of_claim(verdicts: VerdictsByReading, number: int, omega: str) -> dict[int, Verdict]:
    """One claim's verdict under every reading, by the number of the reading.

    Nothing if there are no runs for it, that is, no reading defines any of its parts.
    """
    found: dict[int, Verdict] = {}
    for reading, by_omega in verdicts.items():
        for verdict in by_omega.get(omega, ()):
            if verdict.number == number:
                found[reading] = verdict
    means = [part.effect.mean for v in found.values() for part in claimed(v)]
    return {} if all(map(math.isnan, means)) else found


@dataclass(frozen=True)
class Share:
    """A share of readings, with Wilson's 95 % interval, as if they were drawn at random."""

    count: int
    of: int
    low: float
    high: float

    @property
    def mean(self) -> float:
        """The share; NaN of none."""
        return self.count / self.of if self.of else math.nan


def share(count: int, of: int) -> Share:
    """The share of `count` in `of`, and its interval, which never leaves [0, 1].

    Example:
        >>> found = share(0, 32)
        >>> f"{found.mean:.2f} [{found.low:.2f}, {found.high:.2f}]"
        '0.00 [0.00, 0.11]'
    """
    if of == 0:
        return Share(0, 0, math.nan, math.nan)
    p, shrink = count / of, 1.0 + _Z**2 / of
    centre = (p + _Z**2 / (2 * of)) / shrink
    half = _Z / shrink * math.sqrt(p * (1.0 - p) / of + (_Z / (2 * of)) ** 2)
    return Share(count, of, max(0.0, centre - half), min(1.0, centre + half))


def shares(verdicts: Iterable[Verdict]) -> dict[str, Share]:
    """The share of readings in which a claim holds, fails, and is undecided."""
    counts = Counter(verdict.verdict for verdict in verdicts)
    total = counts[HOLDS] + counts[FAILS] + counts[UNDECIDED]
    return {word: share(counts[word], total) for word in (HOLDS, FAILS, UNDECIDED)}


def claimed(verdict: Verdict) -> list[Part]:
    """The parts of a claim that decide it."""
    return [part for part in verdict.parts if part.verdict != INFORMATION]


def words(parts: Sequence[Part]) -> str:
    """What one part of a claim measures, over readings: some say which designs they leave out."""
    return min((part.what for part in parts), key=len).replace(" - ", " − ")


def margin(verdict: Verdict) -> float:
    """How clearly a claim holds, or fails: one number for all of its parts.

    The distance of a part's effect to its bound, positive on the claimed side, over the half of its
    interval that looks that way; and of several parts (and of a part's two bounds) the least. So a
    claim holds where it is at least 1 and fails where it is below -1. NaN where a part is undefined
    and no other decides against the claim.
    """
    found = [_margin_of(part) for part in claimed(verdict)]
    known = [value for value in found if not math.isnan(value)]
    if not known or (len(known) < len(found) and min(known) >= -1.0):
        return math.nan
    return min(known)


def _margin_of(part: Part) -> float:
    effect = part.effect
    sides = []
    for bound, sign in ((part.low, 1.0), (part.high, -1.0)):
        if math.isinf(bound):
            continue
        distance = sign * (effect.mean - bound)
        below, above = effect.mean - effect.low, effect.high - effect.mean
        half = below if (distance > 0.0) == (sign > 0.0) else above
        if math.isnan(distance) or math.isnan(half):
            return math.nan
        # Without spread, such as of a share of zero in all runs, it is as clear as can be.
        sides.append(distance / half if half > 0.0 else math.copysign(_CLEAR, distance))
    return min(sides)


_CLEAR = 1e3
