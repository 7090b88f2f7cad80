"""Frequency with which a claim is reproduced over the readings, and its margin."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from research.reproduction.claims.atomic import ALIKE, ATOMIC_CLAIMS, AtomicClaim
from research.reproduction.claims.counting import ALL, Count
from research.reproduction.claims.effects import (
    OfGainMap,
    OfTrainings,
    Unmeasured,
    groups_of_effect,
)
from research.reproduction.claims.findings import (
    OPPOSITE,
    REPRODUCED,
    TOO_SMALL,
    Finding,
    findings,
    margin_of,
)
from research.reproduction.table import StudyTable, design_place
from tegotae.systems.recipe import recipe

CLAIMS: tuple[AtomicClaim, ...] = tuple(
    claim
    for claim in ATOMIC_CLAIMS
    if claim.sign != ALIKE and not isinstance(claim.effect, OfTrainings | OfGainMap | Unmeasured)
)
"""The claims that a reading's runs can decide: those with a sign, on the models themselves."""

DRAWS = 1000
"""Number of bootstrap samples of the runs of every model."""

FindingsByReading = Mapping[int, Mapping[str, list[Finding]]]
"""Findings, each of one way to count, by the number of the reading, and then by ω_t: "both", "4",
"8"."""


def findings_by_reading(
    tables: Mapping[int, StudyTable], draws: int = DRAWS, models: Iterable[str] | None = None
) -> FindingsByReading:
    """Return the findings of every claim under each reading, with both ω_t and at each alone.

    Counted is in the study's own way: unsettled episodes left out, mean of runs, by design. Under a
    reading that is not done yet, claims are judged that have all of their models.

    Args:
        tables: the runs by the number of the reading.
        draws: how often runs are drawn anew.
        models: names of those that a reading has when it is done; those of all tables by default.
    """
    models_by_number = {number: set(table["model"].tolist()) for number, table in tables.items()}
    planned = set().union(*models_by_number.values()) if models is None else set(models)
    needed = {claim.name: _models_of(claim, planned) for claim in CLAIMS}
    results = {}
    for number, table in tables.items():
        ready = [claim for claim in CLAIMS if needed[claim.name] <= models_by_number[number]]
        omegas = np.unique(table["omega_t"][np.isfinite(table["omega_t"])])
        results[number] = {
            omega: findings(table, claims=ready, resamples=draws, options=[Count(omega_t=omega)])
            for omega in (ALL, *(f"{omega:g}" for omega in omegas))
        }
    return results


def _models_of(claim: AtomicClaim, models: Iterable[str]) -> set[str]:
    """Return the models that a claim is about."""
    compared = groups_of_effect(claim.effect)
    places = {name: design_place(recipe(name)) for name in models}
    return {
        name
        for name, place in places.items()
        if any(
            place["architecture"] in group.architectures
            and group.observation in ("", place["observation"])
            for group in compared
        )
    }


def of_claim(by_reading: FindingsByReading, name: str, omega: str) -> dict[int, Finding]:
    """Return the findings of one claim under every reading, by the number of the reading.

    Nothing if no reading measures it.
    """
    results = {
        reading: finding
        for reading, by_omega in by_reading.items()
        for finding in by_omega.get(omega, ())
        if finding.claim.name == name
    }
    return results if any(finding.tally.keys() & _WORDS for finding in results.values()) else {}


_WORDS = {REPRODUCED, OPPOSITE, TOO_SMALL}


def outcome_counts(findings: Iterable[Finding]) -> dict[str, int]:
    """Count the readings in which a claim is reproduced, too small to tell, and opposite."""
    counts = Counter(finding.outcome for finding in findings)
    return {word: counts[word] for word in (REPRODUCED, TOO_SMALL, OPPOSITE)}


def claim_margin(finding: Finding) -> float:
    """Return the margin by which a claim is reproduced, or opposite, in the first way to count."""
    return margin_of(finding.claim, next(iter(finding.by_count.values())))
