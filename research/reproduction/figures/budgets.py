"""Effects behind the claims, by the budget of training."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from research.reproduction.claims.atomic import ALIKE
from research.reproduction.claims.estimates import EffectEstimate
from research.reproduction.claims.findings import (
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
)
from tegotae._support.errors import TegotaeError
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled

_ACROSS = 5
_COLUMNS = 25
"""Width of a title's line [characters]."""
LOOK = {
    REPRODUCED: (COLOURS[5], "o"),
    OPPOSITE: (COLOURS[4], "X"),
    TOO_SMALL: ("0.5", "s"),
    SELECTED_FOR: (COLOURS[0], "D"),
}
"""Colour and mark of a verdict."""


def budgets_figure(by_budget: Mapping[str, Sequence[Finding]]) -> Figure:
    """Draw each effect with its 95 % interval over the training budget, one panel per claim.

    Colour and mark say whether the claim is reproduced, opposite, or too small to tell; the shaded
    side of zero is what is claimed. Claims without a sign, or without an effect at any budget, are
    left out.

    Args:
        by_budget: findings, of which the first way to count is drawn, by the budget's heading, such
            as "5120 episodes", ascending.

    Raises:
        TegotaeError: if no claim has an effect.
    """
    claims = drawn_claims(by_budget)
    if not claims:
        raise TegotaeError("no claim has an effect to draw; give at least one that is measured")
    first = next(iter(by_budget.values()))
    titles = {finding.claim.name: finding.claim.title for finding in first}
    across = min(_ACROSS, len(claims))
    rows = -(-len(claims) // across)
    with styled():
        figure = new_figure(PAGE_IN, 1.1 + 1.0 * rows)
        panels = figure.subplots(rows, across, sharex=True, squeeze=False)
        for panel in panels.flat[len(claims) :]:
            panel.set_visible(False)
        for i, (panel, claim) in enumerate(zip(panels.flat, claims, strict=False)):
            _draw(panel, [by_claim[claim] for by_claim in map(_by_claim, by_budget.values())])
            panel.set_title(textwrap.fill(titles[claim], _COLUMNS), loc="left", fontsize=6)
            panel.tick_params(axis="both", labelsize=6)
            if i + across >= len(claims):
                labels = [heading.removesuffix(" episodes") for heading in by_budget]
                panel.set_xticks(range(len(by_budget)), labels)
                panel.tick_params(axis="x", labelbottom=True, labelrotation=90)
                panel.set_xlabel("episodes per run", fontsize=6)
        figure.legend(
            handles=[
                *(
                    Line2D([], [], color=colour, marker=mark, ms=3.5, lw=1.0, label=word)
                    for word, (colour, mark) in LOOK.items()
                    if word != SELECTED_FOR or any(finding.selected for finding in first)
                ),
                Patch(color="0.92", lw=0, label="claimed side of zero"),
            ],
            loc="outside lower center",
            ncols=4,
        )
    return figure


def drawn_claims(by_budget: Mapping[str, Sequence[Finding]]) -> list[str]:
    """Return the names of the claims that the figure has a panel for: with a sign, and an
    effect.
    """
    return [
        claim
        for claim, effects in _effects(by_budget).items()
        if any(estimate.is_known for estimate in effects)
    ]


def _first(finding: Finding) -> EffectEstimate:
    return next(iter(finding.by_count.values()))


def _by_claim(findings: Sequence[Finding]) -> dict[str, Finding]:
    return {finding.claim.name: finding for finding in findings if finding.claim.sign != ALIKE}


def _effects(by_budget: Mapping[str, Sequence[Finding]]) -> dict[str, list[EffectEstimate]]:
    """Return the effects of every claim with a sign, budget by budget."""
    estimates: dict[str, list[EffectEstimate]] = {}
    for findings in by_budget.values():
        for name, finding in _by_claim(findings).items():
            estimates.setdefault(name, []).append(_first(finding))
    return estimates


def _draw(panel: Axes, findings: Sequence[Finding]) -> None:
    effects = [_first(finding) for finding in findings]
    positions = [x for x, estimate in enumerate(effects) if estimate.is_known]
    panel.plot(positions, [effects[x].effect for x in positions], color="0.6", lw=0.5, zorder=1)
    for x in positions:
        estimate = effects[x]
        colour, mark = LOOK[findings[x].verdict(estimate)]
        panel.plot([x, x], [estimate.low, estimate.high], color=colour, lw=1.2)
        panel.plot(x, estimate.effect, mark, color=colour, ms=4, mew=0)
    panel.axhline(0.0, color="black", lw=0.5)
    bottom, top = panel.get_ylim()
    claimed = (0.0, top) if findings[0].claim.sign > 0 else (bottom, 0.0)
    panel.axhspan(*np.clip(claimed, bottom, top), color="0.92", lw=0, zorder=0)
    panel.set(xlim=(-0.5, len(effects) - 0.5), ylim=(bottom, top))
