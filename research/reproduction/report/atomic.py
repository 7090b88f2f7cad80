"""The outcome of each of the paper's claims, as tables of Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from research.frame import markdown_table
from research.reproduction.claims.atomic import ALIKE, EQUIVALENCE, LESS, MORE, AtomicClaim
from research.reproduction.claims.effects import (
    Correlation,
    Difference,
    DoubleDifference,
    Effect,
    OfGainMap,
    OfTrainings,
    Unmeasured,
)
from research.reproduction.claims.estimates import NOT_KNOWN, EffectEstimate
from research.reproduction.claims.findings import (
    NOT_MEASURED,
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
)
from tegotae.measures.hopping.metrics import HOPPING

GROUPS: Mapping[str, Callable[[Finding], bool]] = {
    "The paper's main claims": lambda f: f.claim.headline,
    "Selected for: the body was chosen to agree": lambda f: f.outcome.startswith(SELECTED_FOR),
    "Opposite in every way to count": lambda f: f.is_robust and f.outcome == OPPOSITE,
    "Depends on the way to count": lambda f: f.outcome.startswith("depends on"),
    "Opposite in some ways, and reproduced in none": lambda f: f.outcome.startswith(OPPOSITE),
    "Reproduced in every way to count": lambda f: f.is_robust,
    "Reproduced in some ways, and opposite in none": lambda f: f.outcome.startswith(REPRODUCED),
    "Too small to tell in every way": lambda f: f.outcome == TOO_SMALL,
    "Not measured": lambda f: f.outcome == NOT_MEASURED,
}
"""The groups of the page, in its order; a claim is in the first that it belongs to."""

_MEASURES = {
    "slope": "slope of best σ over ω [1/N]",
    "r_squared": "R² of the line of best σ over ω",
    "resonance_shift": "shift of the best ω over the range of σ [rad/s]",
    "loss": "share of CoT⁻¹ lost 1 rad/s away at the same σ",
    "feedback_while_pushing": "feedback while the actuator pushes [rad/s]",
    "feedback_share": "mean abs(f) / (ω + mean abs(f))",
    "phase_share": "share of the force's variance left beside a line in each of 12 bins of F_k",
    "rate_slope": "slope of the hop rate over ω",
    "nearer_resonance": "how much nearer to the resonance than to ω the hop rate is [rad/s]",
    "fitness": "fitness [m/J]",
}


_ALGORITHMS = {"pgpe": "PGPE", "pgpe-figure3": "PGPE", "sac": "SAC", "ppo": "PPO"}


def outcomes_table(findings: Sequence[Finding]) -> str:
    """Return one table per group of `GROUPS`: words, effect, outcome, and the number of ways for
    each verdict.
    """
    return "\n".join(
        f"**{heading}**\n\n{_group(group)}" for heading, group in grouped_findings(findings).items()
    )


def beside_table(
    findings: Sequence[Finding],
    beside: Mapping[str, Sequence[Finding]],
    columns: Mapping[str, Mapping[str, str]] | None = None,
) -> str:
    """Return one row per claim that several studies measure: its outcome in each.

    Args:
        findings: of the study.
        beside: of other studies, by the heading of their column.
        columns: further columns by their heading: words by the name of the claim.
    """
    outcomes_by_study = [
        {member.claim.name: member.outcome for member in entries} for entries in beside.values()
    ]
    outcomes_by_study += [dict(words) for words in (columns or {}).values()]
    rows = [["", "the study", *beside, *(columns or {})]]
    for finding in (member for group in grouped_findings(findings).values() for member in group):
        outcomes = [
            finding.outcome,
            *(entries.get(finding.claim.name, "") for entries in outcomes_by_study),
        ]
        if set(outcomes) - {NOT_MEASURED}:
            rows.append([claim_label(finding.claim), *outcomes])
    return markdown_table(rows)


def designs_table(studies: Mapping[str, Sequence[Finding]]) -> str:
    """Return one row per claim and study that measures it over designs and ω_t: both intervals, and
    what they say, in the first way to count.

    Args:
        studies: findings by the study's name.
    """
    rows = [["", "Study", "Effect", "Over runs", "Over designs and ω_t", "By runs", "By designs"]]
    for i, claim in enumerate(finding.claim for finding in next(iter(studies.values()))):
        title = claim_label(claim)
        for study, findings in studies.items():
            finding = findings[i]
            estimate = next(iter(finding.by_count.values()))
            if estimate.over_designs.is_known:
                words = map(finding.verdict, (estimate, estimate.over_designs))
                rows.append(
                    [title, study, f"{estimate.effect:+.2f}", *_intervals(estimate), *words]
                )
                title = ""
    return markdown_table(rows)


def grouped_findings(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """Return findings by the headings of `GROUPS`, without empty headings."""
    remaining, by_heading = list(findings), {}
    for heading, belongs in GROUPS.items():
        group = [finding for finding in remaining if belongs(finding)]
        remaining = [finding for finding in remaining if finding not in group]
        if group:
            by_heading[heading] = group
    return by_heading


def _group(findings: Sequence[Finding]) -> str:
    head = ["Claim, and the paper's words", "Measured", "Effect", "Over runs"]
    rows = [[*head, "Over designs and ω_t", "Outcome", "Ways: + / 0 / −"]]
    for finding in findings:
        claim = finding.claim
        rows.append(
            [
                f"**{claim.title}**, `{claim.name}`: "
                f"“{quoted(claim).replace('|', '&#124;')}” ({claim.section})",
                "; ".join(filter(None, (effect_in_words(claim.effect), claim.note))),
                _effect(finding),
                *_intervals(shown_effect(finding) or NOT_KNOWN),
                f"**{finding.outcome}**",
                tally(finding),
            ]
        )
    return markdown_table(rows)


def claim_label(claim: AtomicClaim) -> str:
    """Return a claim's title and name, for a cell of a table."""
    return f"{claim.title}, `{claim.name}`"


def quoted(claim: AtomicClaim) -> str:
    """Return the paper's words, without the marks of mathematics."""
    return claim.words.replace("CoT^{-1}", "CoT⁻¹").replace(r"\dot{y}", "ẏ")


def shown_effect(finding: Finding) -> EffectEstimate | None:
    """Return the effect as the study counts it, or in the first way that measures it."""
    return next((estimate for estimate in finding.by_count.values() if estimate.is_known), None)


def _effect(finding: Finding) -> str:
    """Return the mean, the level that it is compared with, and the claimed sign."""
    estimate = shown_effect(finding)
    claimed = CLAIMED[finding.claim.sign]
    if estimate is None:
        return claimed
    size = "" if np.isnan(estimate.size) or _is_plain(finding) else f" of {estimate.size:.2f}"
    return ", ".join(filter(None, (f"{estimate.effect:+.2f}{size}", claimed)))


def _intervals(estimate: EffectEstimate) -> tuple[str, str]:
    """Return the 95 % intervals over runs, and over designs and ω_t."""
    ends = (estimate.low, estimate.high), (estimate.designs_low, estimate.designs_high)
    texts = ["–" if np.isnan(low) else f"[{low:.2f}, {high:.2f}]" for low, high in ends]
    return texts[0], texts[1]


CLAIMED = {
    MORE: "claimed > 0",
    LESS: "claimed < 0",
    ALIKE: "claimed within {:+.0%} and {:+.0%}".format(*(share - 1.0 for share in EQUIVALENCE)),
}
"""Claimed effects as text, by sign."""


def _is_plain(finding: Finding) -> bool:
    """Return whether an effect is a difference to nothing, which is no size."""
    return isinstance(finding.claim.effect, Correlation)


def tally(finding: Finding) -> str:
    """Count the ways to count that agree with a claim, are too small to tell, and are opposite."""
    counts_by_word = finding.tally
    counts = [counts_by_word[word] for word in (finding.agreeing, TOO_SMALL, OPPOSITE)]
    return " / ".join(map(str, counts)) if any(counts) else "–"


def effect_in_words(effect: Effect) -> str:
    """Return an effect in words, with its unit.

    Example:
        >>> from research.reproduction.claims.atomic import ATOMIC_CLAIMS
        >>> effect_in_words(ATOMIC_CLAIMS[0].effect)
        'CoT⁻¹ [m/J], AR, ART, ARG, ARGT − V'
    """
    if isinstance(effect, Unmeasured):
        return effect.description
    if isinstance(effect, Correlation):
        return f"correlation of {HOPPING.find(effect.a).label} and {HOPPING.find(effect.b).label}"
    if isinstance(effect, DoubleDifference):
        (a, b), (c, d) = effect.ours, effect.theirs
        return f"{_heading(effect.metric)}, ({a.label} − {b.label}) − ({c.label} − {d.label})"
    if isinstance(effect, OfTrainings):
        ours, theirs = (_ALGORITHMS.get(side, side) for side in (effect.ours, effect.theirs))
        return f"{_heading(effect.metric)}, {ours}{f' − {theirs}' if theirs else ''}"
    if isinstance(effect, OfGainMap):
        theirs = f" − {effect.theirs}" if effect.theirs else ""
        return f"{_heading(effect.measure)}, {effect.ours}{theirs}"
    metric = effect.metric if isinstance(effect, Difference) else effect.measure
    theirs = "" if effect.theirs is None else f" − {effect.theirs.label}"
    if isinstance(effect, Difference) and effect.lowest:
        theirs = " − the lowest other"
    return f"{_heading(metric)}, {effect.ours.label}{theirs}"


def effect_unit(effect: Effect) -> str:
    """Return the unit of an effect, such as m/J; empty for a share, a correlation and a slope.

    Example:
        >>> from research.reproduction.claims.atomic import ATOMIC_CLAIMS
        >>> effect_unit(ATOMIC_CLAIMS[0].effect)
        'm/J'
    """
    name = getattr(effect, "measure", None) or getattr(effect, "metric", None)
    _, _, last = (_heading(name) if name else "").partition(" [")
    return last.removesuffix("]")


def _heading(name: str) -> str:
    return _MEASURES[name] if name in _MEASURES else HOPPING.find(name).heading


def by_budget_table(by: Mapping[str, Iterable[Finding]]) -> str:
    """Return one row per claim that the study's table measures: its verdict after each budget.

    Args:
        by: findings, of which the first way to count is taken, by the heading of their column.
    """
    verdicts = {
        heading: {
            claim_label(finding.claim): next(iter(finding.verdicts.values()))
            for finding in findings
        }
        for heading, findings in by.items()
    }
    rows = [["", *verdicts]]
    for name in next(iter(verdicts.values())):
        words = [findings[name] for findings in verdicts.values()]
        if set(words) - {NOT_MEASURED}:
            rows.append([name, *words])
    return markdown_table(rows)
