"""When does a verdict turn? The effects behind the claims, by how long was trained."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from tegotae._support.errors import TegotaeError
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.studies.paper.claims.verdict import (
    FAILS,
    HOLDS,
    INFORMATION,
    UNDECIDED,
    Part,
    Verdict,
)

Budget = float | str
"""Episodes per run; or a word, such as "plateau", where runs had as many as they needed."""

_ACROSS = 4
_LOOK = {HOLDS: (COLOURS[5], "o"), FAILS: (COLOURS[4], "X"), UNDECIDED: ("0.5", "s")}
_BEYOND = 2.5
"""Where a budget that is a word stands: so many times further right than the one before."""


def parts_by_budget(
    verdicts: Mapping[Budget, Sequence[Verdict]],
) -> dict[tuple[int, str], dict[Budget, Part]]:
    """Each part of a claim that has a bound, by budget; by the claim's number and what it measures.

    A part that says how many designs it compares is the same part with another number of them.
    """
    found: dict[tuple[int, str], dict[Budget, Part]] = {}
    for budget, of_budget in verdicts.items():
        for verdict in of_budget:
            for part in verdict.parts:
                if part.verdict != INFORMATION:
                    what = re.sub(r" \(\d+ of \d+ designs\)$", "", part.what)
                    found.setdefault((verdict.number, what), {})[budget] = part
    return dict(sorted(found.items(), key=lambda item: item[0][0]))


def budgets_figure(verdicts: Mapping[Budget, Sequence[Verdict]]) -> Figure:
    """Each effect with its 95 % interval over the training budget, a panel a part of a claim.

    Colour and mark say whether that part holds, fails or is undecided; the line is the bound, and
    the shaded side is what is claimed.

    Args:
        verdicts: by budget: episodes per run; a word ("plateau") stands to the right of them all.

    Raises:
        TegotaeError: if there is no part with a bound, or a number of episodes is not above 0.
    """
    parts = parts_by_budget(verdicts)
    if not parts:
        raise TegotaeError("no verdicts to draw; give at least one with a measured effect")
    places = _places(tuple(verdicts))
    across = min(_ACROSS, len(parts))
    rows = -(-len(parts) // across)
    with styled():
        figure = new_figure(PAGE_IN, 0.9 + 1.3 * rows)
        panels = figure.subplots(rows, across, sharex=True, squeeze=False)
        for panel in panels.flat[len(parts) :]:
            panel.set_visible(False)
        for i, (panel, ((number, what), by_budget)) in enumerate(
            zip(panels.flat, parts.items(), strict=False)
        ):
            panel.set_title(textwrap.fill(f"{number}: {what}", 34), loc="left", fontsize=6.5)
            _draw(panel, by_budget, places)
            if i + across >= len(parts):
                panel.set_xlabel("episodes per run")
                panel.tick_params(axis="x", labelbottom=True, labelrotation=90, labelsize=6)
        _axis(panels[0, 0], places)
        figure.legend(
            handles=[
                *(
                    Line2D([], [], color=colour, marker=mark, ms=3.5, lw=1.0, label=verdict)
                    for verdict, (colour, mark) in _LOOK.items()
                ),
                Line2D([], [], color="black", lw=0.7, ls="--", label="bound"),
                Patch(color="0.92", lw=0, label="claimed side"),
            ],
            loc="outside lower center",
            ncols=5,
        )
    return figure


def _places(budgets: tuple[Budget, ...]) -> dict[Budget, float]:
    """Where each budget stands on the axis: numbers rising, then words."""
    numbers = sorted(b for b in budgets if not isinstance(b, str))
    for number in numbers:
        if not (np.isfinite(number) and number > 0):
            raise TegotaeError(f"a budget is {number:g} episodes; it must be greater than 0")
    places: dict[Budget, float] = {number: float(number) for number in numbers}
    for word in (b for b in budgets if isinstance(b, str)):
        places[word] = _BEYOND * max([*places.values(), 1.0])
    return places


def _draw(panel: Axes, by_budget: Mapping[Budget, Part], places: Mapping[Budget, float]) -> None:
    ordered = sorted(by_budget.items(), key=lambda item: places[item[0]])
    known = [(places[b], part) for b, part in ordered if np.isfinite(part.effect.mean)]
    panel.plot(
        [x for x, _ in known],
        [part.effect.mean for _, part in known],
        color="0.6",
        lw=0.5,
        zorder=1,
    )
    for x, part in known:
        colour, mark = _LOOK[part.verdict]
        effect = part.effect
        if np.isfinite(effect.low):
            panel.plot([x, x], [effect.low, effect.high], color=colour, lw=1.2)
        panel.plot(x, effect.mean, mark, color=colour, ms=4, mew=0)
    _bounds(panel, ordered, places)
    if not known:
        panel.text(0.5, 0.5, "not measured", transform=panel.transAxes, ha="center", fontsize=6)
        panel.set_yticks([])


def _bounds(
    panel: Axes, ordered: Sequence[tuple[Budget, Part]], places: Mapping[Budget, float]
) -> None:
    """A line for each bound, which may differ by budget, and the claimed side shaded."""
    x = np.array([places[b] for b, _ in ordered])
    lows = np.array([part.low for _, part in ordered])
    highs = np.array([part.high for _, part in ordered])
    for bound in (lows, highs):
        if np.isfinite(bound).any():
            if np.ptp(bound[np.isfinite(bound)]) == 0.0:
                panel.axhline(bound[np.isfinite(bound)][0], color="black", lw=0.7, ls="--")
            else:
                panel.plot(x, bound, color="black", lw=0.7, ls="--")
    bottom, top = panel.get_ylim()
    edges = np.concatenate([[x[0] / 10.0], x, [10.0 * x[-1]]])
    under, over = (np.clip(np.pad(b, 1, mode="edge"), bottom, top) for b in (lows, highs))
    panel.fill_between(edges, under, over, color="0.92", lw=0, zorder=0)
    panel.set_ylim(bottom, top)


def _axis(panel: Axes, places: Mapping[Budget, float]) -> None:
    """Ticks at the budgets alone, on a logarithmic axis."""
    at = list(places.values())
    panel.set_xscale("log")
    panel.xaxis.set_minor_locator(NullLocator())
    panel.set_xticks(at, [_named(budget) for budget in places])
    panel.set_xlim(min(at) / 1.6, 1.6 * max(at))


def _named(budget: Budget) -> str:
    if isinstance(budget, str):
        return budget
    return f"{budget / 1000:.3g}k" if budget >= 1000 else f"{budget:g}"
