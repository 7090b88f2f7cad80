"""All claims at a glance: the effect behind each, and how many ways to count agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from reproduction.claims.atomic import ALIKE
from reproduction.claims.findings import OPPOSITE, REPRODUCED, TOO_SMALL, Finding, verdict
from reproduction.figures.budgets import LOOK
from reproduction.report.atomic import grouped, shown_effect
from tegotae._support.errors import TegotaeError
from tegotae.figures.style import PAGE_IN, new_figure, styled

_ROW_IN = 0.155
_BARS = {
    REPRODUCED: (LOOK[REPRODUCED][0], ""),
    TOO_SMALL: ("0.85", ""),
    OPPOSITE: (LOOK[OPPOSITE][0], "////"),
}
"""Colour and hatch of a share: they differ in grey print, too."""


def claims_figure(findings: Sequence[Finding]) -> Figure:
    """The effect of every claim that has a sign, with its 95 % interval, and a bar of its ways.

    Right of zero is what the paper claims. Each effect is drawn over the largest number of its own
    interval, since effects have different units; the numbers beside it are in these units. The bar
    is the share of the ways to count that reproduce the claim, are too uncertain, or oppose it.

    Args:
        findings: of the study; the first way to count that measures an effect is drawn.

    Raises:
        TegotaeError: if no claim has an effect.
    """
    rows = _rows(grouped(findings))
    if not rows:
        raise TegotaeError("no claim has an effect to draw; give at least one that is measured")
    with styled():
        figure = new_figure(PAGE_IN, _ROW_IN * len(rows) + 0.9)
        effects, ways = figure.subplots(1, 2, width_ratios=(2.2, 1.0), sharey=True)
        for y, row in enumerate(rows):
            if isinstance(row, str):
                effects.text(-0.52, y, row, size=6.5, weight="bold", va="center", clip_on=False,
                             transform=effects.get_yaxis_transform())  # fmt: skip
            else:
                _draw_effect(effects, y, row)
                _draw_ways(ways, y, row)
        drawn = [(y, row.claim.title) for y, row in enumerate(rows) if not isinstance(row, str)]
        effects.set_yticks(*map(list, zip(*drawn, strict=True)), size=6)
        effects.set(
            xlim=(-1.05, 1.75),
            ylim=(len(rows) - 0.4, -0.6),
            xlabel="against the claim ← 0 → as claimed",
        )
        effects.set_xticks([])
        effects.axvline(0.0, color="black", lw=0.6)
        effects.axvspan(0.0, 1.05, color="0.94", lw=0, zorder=0)
        ways.set(xlim=(0.0, 1.0), xlabel="share of the ways to count")
        for axes in (effects, ways):
            axes.tick_params(axis="y", length=0)
            axes.spines["left"].set_visible(False)
        figure.legend(handles=_handles(), loc="outside lower center", ncols=3)
    return figure


def has_effects(findings: Sequence[Finding]) -> bool:
    """Whether the figure has a row to draw."""
    return bool(_rows(grouped(findings)))


def _rows(groups: Mapping[str, Sequence[Finding]]) -> list[str | Finding]:
    """Headings, each followed by its findings that have a sign and an effect."""
    rows: list[str | Finding] = []
    for heading, own in groups.items():
        drawn = [each for each in own if each.claim.sign != ALIKE and shown_effect(each)]
        rows += [heading, *drawn] if drawn else []
    return rows


def _draw_effect(axes: Axes, y: int, finding: Finding) -> None:
    found, sign = shown_effect(finding), finding.claim.sign
    assert found is not None
    scale = sign / max(abs(found.low), abs(found.high), abs(found.effect))
    colour, mark = LOOK[verdict(finding.claim, found)]
    axes.plot([scale * found.low, scale * found.high], [y, y], color=colour, lw=1.4)
    axes.plot(scale * found.effect, y, mark, color=colour, ms=4, mew=0)
    text = f"{found.effect:+.2f} [{found.low:.2f}, {found.high:.2f}]"
    axes.text(1.1, y, text, size=6, va="center")


def _draw_ways(axes: Axes, y: int, finding: Finding) -> None:
    counts = {word: finding.tally[word] for word in _BARS}
    left, whole = 0.0, max(sum(counts.values()), 1)
    for word, count in counts.items():
        axes.barh(
            y,
            count / whole,
            left=left,
            height=0.7,
            color=_BARS[word][0],
            hatch=_BARS[word][1],
            edgecolor="white",
            lw=0,
        )
        left += count / whole
    axes.text(1.02, y, f"{whole}", size=6, va="center", clip_on=False)


def _handles() -> list[Line2D | Patch]:
    lines = [
        Line2D([], [], color=colour, marker=mark, ms=3.5, lw=1.2, label=word)
        for word, (colour, mark) in LOOK.items()
    ]
    return [*lines, Patch(color="0.92", lw=0, label="claimed side of zero")]
