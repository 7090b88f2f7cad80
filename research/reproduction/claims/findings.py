"""Findings of each claim under every way to count, and the choices on which they depend."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from research.reproduction.claims.atomic import ALIKE, ATOMIC_CLAIMS, EQUIVALENCE, AtomicClaim
from research.reproduction.claims.counting import CHOICES, Count, counts, differ_in
from research.reproduction.claims.effects import OfGainMap, OfTrainings
from research.reproduction.claims.estimates import EffectEstimate, estimate_effect
from research.reproduction.claims.experiments import require_folder
from research.reproduction.claims.kept import measure_kept
from research.reproduction.claims.resampling import RESAMPLES, Resampled
from research.reproduction.table import StudyTable

REPRODUCED, OPPOSITE = "reproduced", "opposite"
TOO_SMALL, NOT_MEASURED = "too small to tell", "not measured"
SELECTED_FOR = "selected for"
"""Instead of `REPRODUCED`, of a statement that the body was chosen to agree with."""

EVERYWHERE = Count()
"""The count of an effect that is not of the study's table: there is one way."""


def verdict(claim: AtomicClaim, estimate: EffectEstimate) -> str:
    """Return the verdict of an effect on a claim: `REPRODUCED` if its interval has the claimed
    sign, `OPPOSITE` if it has the other, `TOO_SMALL` if it has both. An effect is alike if the
    interval lies within `EQUIVALENCE`, and it is the opposite if it lies outside.

    Example:
        >>> verdict(ATOMIC_CLAIMS[0], EffectEstimate(0.2, 0.1, 0.3))
        'reproduced'
    """
    if not estimate.is_known:
        return NOT_MEASURED
    if claim.sign == ALIKE:
        lower, upper = sorted((share - 1.0) * estimate.size for share in EQUIVALENCE)
        if lower < estimate.low and estimate.high < upper:
            return REPRODUCED
        return OPPOSITE if estimate.high < lower or upper < estimate.low else TOO_SMALL
    low, high = sorted((claim.sign * estimate.low, claim.sign * estimate.high))
    if low > 0.0:
        return REPRODUCED
    return OPPOSITE if high < 0.0 else TOO_SMALL


CLEAR = 1e3
"""The margin of an effect without spread, such as of a share of zero in all runs."""


def margin_of(claim: AtomicClaim, estimate: EffectEstimate) -> float:
    """Return the margin by which a claim with a sign is reproduced, or opposite.

    The effect, positive on the claimed side, over the half of its interval that looks towards zero:
    a claim is reproduced where it is above 1, and opposite where it is below -1. NaN if it is not
    measured.

    Example:
        >>> f"{margin_of(ATOMIC_CLAIMS[0], EffectEstimate(0.2, 0.1, 0.3)):.0f}"
        '2'
    """
    if not estimate.is_known:
        return math.nan
    half = (
        estimate.effect - estimate.low if estimate.effect > 0.0 else estimate.high - estimate.effect
    )
    signed = claim.sign * estimate.effect
    return signed / half if half > 0.0 else math.copysign(CLEAR, signed)


@dataclass(frozen=True)
class Finding:
    """A claim's effect in every way to count.

    Args:
        claim: the claim.
        by_count: the effect by the way to count, the study's own way first.
        selected: whether the body was chosen to agree with the claim, so that it is no test of it.
    """

    claim: AtomicClaim
    by_count: Mapping[Count, EffectEstimate]
    selected: bool = False

    @property
    def agreeing(self) -> str:
        """The verdict of a way that agrees with the claim."""
        return SELECTED_FOR if self.selected else REPRODUCED

    def verdict(self, estimate: EffectEstimate) -> str:
        """Return the verdict of an effect on the claim."""
        word = verdict(self.claim, estimate)
        return self.agreeing if word == REPRODUCED else word

    @property
    def verdicts(self) -> dict[Count, str]:
        """The verdict by the way to count."""
        return {count: self.verdict(estimate) for count, estimate in self.by_count.items()}

    @property
    def tally(self) -> Counter[str]:
        """Count the ways to count by verdict."""
        return Counter(self.verdicts.values())

    @property
    def is_robust(self) -> bool:
        """True if several ways to count all decide it, and alike."""
        return len(self.by_count) > 1 and set(self.tally) in ({self.agreeing}, {OPPOSITE})

    @property
    def outcome(self) -> str:
        """One verdict for all ways to count.

        The verdict itself if all that measure it have it; "reproduced, or too small to tell" if
        some have that and none the opposite, and the other way round; "depends on" and the choices
        if both signs are found.
        """
        tally = self.tally
        if tally[self.agreeing] and tally[OPPOSITE]:
            words = [CHOICES[name] for name in self.depends_on] or ["several choices together"]
            return f"depends on {', '.join(words)}"
        for word in (self.agreeing, OPPOSITE):
            if tally[word]:
                return f"{word}, or {TOO_SMALL}" if tally[TOO_SMALL] else word
        return TOO_SMALL if tally[TOO_SMALL] else NOT_MEASURED

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The choices that turn it: two ways that differ in this alone find opposite signs."""
        choices = set()
        for (a, first), (b, second) in itertools.combinations(self.verdicts.items(), 2):
            differences = differ_in(a, b)
            if len(differences) == 1 and {first, second} == {self.agreeing, OPPOSITE}:
                choices.add(differences[0])
        return tuple(name for name in CHOICES if name in choices)


def findings(
    table: StudyTable,
    experiments: Path | None = None,
    claims: Iterable[AtomicClaim] = ATOMIC_CLAIMS,
    resamples: int = RESAMPLES,
    options: Iterable[Count] | None = None,
    selected: Collection[str] = (),
) -> list[Finding]:
    """Return the effect of every claim in every way to count.

    Args:
        table: the study's runs, or their episodes. Experiments beside the paper's models decide
            nothing.
        experiments: folder of the experiments' tables (Figs. 3 and 4, number of parameters).
        claims: which claims.
        resamples: how often the runs are drawn anew.
        options: the ways to count; all that the table allows by default. A claim about one kind of
            run is counted by this kind in each.
        selected: names of the claims that the table's body was chosen to agree with.

    Raises:
        TegotaeError: if there is no such folder, or a table in it cannot be read.
    """
    require_folder(experiments)
    runs = Resampled(table.of_the_paper(), resamples)
    options = list(counts(runs.table) if options is None else options)
    results = []
    for claim in claims:
        if isinstance(claim.effect, OfTrainings | OfGainMap):
            by_count = {EVERYWHERE: measure_kept(claim.effect, experiments)}
        else:
            matching = dict.fromkeys(
                replace(option, run=claim.run or option.run) for option in options
            )
            by_count = {count: estimate_effect(claim.effect, runs, count) for count in matching}
        results.append(Finding(claim, by_count, claim.name in selected))
    return results
