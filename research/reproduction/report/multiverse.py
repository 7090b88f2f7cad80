"""The multiverse's shares as a table of Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from research.frame import markdown_table
from research.reproduction.claims.counting import ALL, MEAN
from research.reproduction.claims.findings import (
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
)
from research.reproduction.readings.designs import selecting
from research.reproduction.readings.influence import decisive, influences
from research.reproduction.readings.readings import ALLOWED, Reading
from research.reproduction.readings.verdicts import (
    CLAIMS,
    FindingsByReading,
    of_claim,
    outcome_counts,
)
from research.reproduction.report.atomic import claim_label, effect_in_words, quoted
from tegotae.measures.statistics import share_interval

READINGS_COLUMN, ALLOWED_COLUMN = "Readings: + / 0 / −", "Those that the text allows"
"""The headings of `counts_by_claim`, beside the outcomes of one study."""


def shares_table(
    readings: Sequence[Reading], by_reading: FindingsByReading, omega: str = ALL
) -> str:
    """Return one row per claim that a reading measures: in which share of readings it is
    reproduced, with a 95 % interval, in how many of those that the text allows, and what decides.

    Args:
        readings: all readings.
        by_reading: what comes of the claims under each.
        omega: on which ω_t, "both", "4" or "8".
    """
    has_own, selected = readings[0] == Reading(), selecting(readings)
    allowed = {
        heading: among
        for heading, is_allowed in ALLOWED.items()
        if len(among := {n for n, candidate in enumerate(readings) if is_allowed(candidate)})
        < len(readings)
    }
    head = ["", "The paper's words", "Reproduced", "Too small to tell", "Opposite"]
    head += [f"{heading}: + / 0 / −" for heading in allowed]
    rows = [[*head, *(["Reading 0"] if has_own else []), "What decides (ρ)"]]
    for claim in CLAIMS:
        if not (findings := of_claim(by_reading, claim.name, omega)):
            continue
        counts = outcome_counts(findings.values())
        clear = decisive(influences(readings, findings))
        deciding = ", ".join(f"{i.choice.label} ({i.correlation:+.2f})" for i in clear)
        outcomes = [findings[0].outcome if 0 in findings else "–"] if has_own else []
        by_run = {count.run for finding in findings.values() for count in finding.by_count}
        of_runs = f", by the {'; '.join(by_run)}" if by_run - {claim.run or MEAN} else ""
        rows.append(
            [
                claim_label(claim),
                f"“{quoted(claim)}”<br>{effect_in_words(claim.effect)}{of_runs}",
                f"{SELECTED_FOR}: " * (claim.name in selected) + _share(counts, REPRODUCED),
                *(_share(counts, word) for word in (TOO_SMALL, OPPOSITE)),
                *(
                    _counts(findings[n] for n in findings if n in among)
                    for among in allowed.values()
                ),
                *outcomes,
                deciding.replace("-", "−") or "–",
            ]
        )
    return markdown_table(rows)


def counts_by_claim(
    readings: Sequence[Reading], by_reading: FindingsByReading, omega: str = ALL
) -> dict[str, dict[str, str]]:
    """Return, in words, the numbers of readings in which each claim is reproduced, too small to
    tell, and opposite.

    By the heading of a column: among all readings, and among those that the text allows.

    Args:
        readings: all readings.
        by_reading: what comes of the claims under each.
        omega: on which ω_t, "both", "4" or "8".
    """
    is_allowed = list(ALLOWED.values())[-1]
    allowed = {n: findings for n, findings in by_reading.items() if is_allowed(readings[n])}
    columns = {}
    for heading, among in ((READINGS_COLUMN, by_reading), (ALLOWED_COLUMN, allowed)):
        columns[heading] = {}
        for claim in CLAIMS:
            if counts := _counts(of_claim(among, claim.name, omega).values()):
                remark = f", {SELECTED_FOR}" if claim.name in selecting(readings) else ""
                columns[heading][claim.name] = counts + remark
    return columns


def _counts(findings: Iterable[Finding]) -> str:
    """Return the numbers of readings that agree, are too small to tell, and are opposite; empty for
    none."""
    counts = outcome_counts(findings).values()
    return " / ".join(map(str, counts)) if any(counts) else ""


def _share(counts: Mapping[str, int], word: str) -> str:
    count, total = counts[word], sum(counts.values())
    if not total:
        return "–"
    share = share_interval(count, total)
    return f"{count} of {total} [{share.low:.0%}, {share.high:.0%}]".replace("%", " %")
