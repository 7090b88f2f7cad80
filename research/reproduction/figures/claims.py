"""All claims at a glance: the effect behind each, and how many ways to count agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from research.reproduction.claims.atomic import ALIKE
from research.reproduction.claims.findings import (
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
    margin_of,
)
from research.reproduction.figures.budgets import LOOK
from research.reproduction.report.atomic import effect_unit, grouped_findings, shown_effect
from tegotae._support.errors import TegotaeError
from tegotae.figures.style import PAGE_IN, new_figure, styled

_ROW_IN = 0.155
_BARS = {
    REPRODUCED: (LOOK[REPRODUCED][0], ""),
    SELECTED_FOR: (LOOK[SELECTED_FOR][0], "...."),
    TOO_SMALL: ("0.85", ""),
    OPPOSITE: (LOOK[OPPOSITE][0], "////"),
}
"""Colour and hatch of a share: they differ in grey print, too."""
_HOLLOW = {"marker": "o", "mfc": "white", "mec": "black", "ms": 3, "mew": 0.6}
"""The mark of the interval over designs and frequencies."""


def claims_figure(findings: Sequence[Finding]) -> Figure:
    """Draw the clarity of every claim's effect, the effect in its unit, and a bar of its ways.

    Effects have different units, so that the scale is how far each is from zero in halves of its
    own 95 % interval over runs: right of 1 it is as the paper claims, left of -1 the opposite. A
    hollow mark is the same of the interval over designs and training frequencies. The bar is the
    share of the ways to count that agree with the claim, are too uncertain, or oppose it. A claim
    that two things are alike has no such distance.

    Args:
        findings: of the study; the first way to count that measures an effect is drawn.

    Raises:
        TegotaeError: if no claim has an effect.
    """
    rows = _rows(grouped_findings(findings))
    if not rows:
        raise TegotaeError("no claim has an effect to draw; give at least one that is measured")
    with styled():
        figure = new_figure(PAGE_IN, _ROW_IN * len(rows) + 1.0)
        panels = figure.subplots(1, 3, width_ratios=(1.3, 0.95, 0.8), sharey=True)
        effects, numbers, tallies = panels
        for y, row in enumerate(rows):
            if isinstance(row, str):
                effects.text(-0.75, y, row, size=6.5, weight="bold", va="center", clip_on=False,
                             transform=effects.get_yaxis_transform())  # fmt: skip
            else:
                _draw_effect(effects, y, row)
                numbers.text(0.0, y, _number(row), size=6, va="center")
                _draw_ways(tallies, y, row)
        drawn = [(y, row.claim.title) for y, row in enumerate(rows) if not isinstance(row, str)]
        effects.set_yticks(*map(list, zip(*drawn, strict=True)), size=6)
        effects.set_xscale("symlog", linthresh=1.0)
        effects.set(
            xlim=(-_MOST, _MOST),
            ylim=(len(rows) - 0.4, -0.6),
            xlabel="distance from zero\nin halves of its 95 % interval",
        )
        effects.set_xticks([-100, -10, -1, 0, 1, 10, 100], minor=False)
        effects.set_xticklabels(["−100", "−10", "−1", "0", "1", "10", "100"])
        effects.minorticks_off()
        effects.axvline(0.0, color="black", lw=0.6)
        effects.axvspan(1.0, _MOST, color="0.94", lw=0, zorder=0)
        effects.axvspan(-_MOST, -1.0, color="0.94", lw=0, zorder=0)
        numbers.set(xlim=(0.0, 1.0), xlabel="effect [95 %], unit")
        numbers.set_xticks([])
        tallies.set(xlim=(0.0, 1.0), xlabel="share of the ways\nto count", xticks=(0.0, 0.5, 1.0))
        for axes in panels:
            axes.patch.set_visible(False)  # headings reach into the next panel
            axes.tick_params(axis="y", length=0)
            axes.spines["left"].set_visible(False)
        numbers.spines["bottom"].set_visible(False)
        figure.legend(handles=_handles(rows), loc="outside lower center", ncols=6)
    return figure


_MOST = 1e3


def has_effects(findings: Sequence[Finding]) -> bool:
    """Return whether the figure has a row to draw."""
    return bool(_rows(grouped_findings(findings)))


def _rows(groups: Mapping[str, Sequence[Finding]]) -> list[str | Finding]:
    """Return headings, each followed by its findings that have an effect."""
    rows: list[str | Finding] = []
    for heading, group in groups.items():
        drawn = [finding for finding in group if shown_effect(finding)]
        rows += [heading, *drawn] if drawn else []
    return rows


def _draw_effect(axes: Axes, y: int, finding: Finding) -> None:
    estimate = shown_effect(finding)
    assert estimate is not None
    if finding.claim.sign == ALIKE:
        return
    colour, mark = LOOK[finding.verdict(estimate)]
    x = float(np.clip(margin_of(finding.claim, estimate), -0.9 * _MOST, 0.9 * _MOST))
    axes.plot([0.0, x], [y, y], color=colour, lw=1.4)
    axes.plot(x, y, mark, color=colour, ms=4, mew=0)
    if estimate.over_designs.is_known:
        axes.plot(margin_of(finding.claim, estimate.over_designs), y, **_HOLLOW)


def _number(finding: Finding) -> str:
    estimate = shown_effect(finding)
    assert estimate is not None
    interval = f"[{estimate.low:.2f}, {estimate.high:.2f}]"
    text = f"{estimate.effect:+.2f} {interval} {effect_unit(finding.claim.effect)}"
    return text.replace("-", "−")


def _draw_ways(axes: Axes, y: int, finding: Finding) -> None:
    counts = {word: finding.tally[word] for word in _BARS}
    start, total = 0.0, max(sum(counts.values()), 1)
    for word, count in counts.items():
        axes.barh(
            y,
            count / total,
            left=start,
            height=0.7,
            color=_BARS[word][0],
            hatch=_BARS[word][1],
            edgecolor="white",
            lw=0,
        )
        start += count / total
    axes.text(1.02, y, f"{total}", size=6, va="center", clip_on=False)


def _handles(rows: Sequence[str | Finding]) -> list[Line2D | Patch]:
    """Return a line for each verdict; that of a body chosen to agree only where there is one."""
    selected = any(row.selected for row in rows if not isinstance(row, str))
    lines: list[Line2D | Patch] = [
        Line2D([], [], color=colour, marker=mark, ms=3.5, lw=1.2, label=word)
        for word, (colour, mark) in LOOK.items()
        if word != SELECTED_FOR or selected
    ]
    designs = Line2D([], [], ls="", label=r"over designs and $\omega_t$", **_HOLLOW)
    return [*lines, designs, Patch(color="0.94", lw=0, label="beyond its interval")]
