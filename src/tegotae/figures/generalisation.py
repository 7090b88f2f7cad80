"""Curves of what is kept under disturbances, from none of them to failure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator

from tegotae.analysis.generalisation.disturbances import Disturbance
from tegotae.analysis.generalisation.run import MEASURES, Done
from tegotae.figures.style import COLOURS, PAGE_IN, literal_text, new_figure, styled
from tegotae.measures.statistics import Interval, share_interval

_MOST_LINES = len(COLOURS)
"""Lines that a panel can distinguish."""
FEW = 2
"""Number of runs below which no interval is drawn: of one run it would cover the panel."""
_COLUMNS = 4
_TICKS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)
_DASHES = ("-", "--", "-.", ":")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""Lines and marks, for those who print in grey."""


def curves_figure(results: Sequence[Done], disturbances: Sequence[Disturbance]) -> Figure:
    """Draw the share of each controller's runs that keep their gait, one panel per disturbance.

    Of more controllers than there are colours all are one line.
    """
    groups = {tested.name: [(tested, outcome)] for tested, outcome in results}
    if len(groups) > _MOST_LINES:
        groups = {f"{len(results)} controllers": list(results)}
    return groups_figure(groups, disturbances)


@styled()
def groups_figure(
    groups: Mapping[str, Sequence[Done]], disturbances: Sequence[Disturbance]
) -> Figure:
    """Draw one panel per disturbance and one line per group of controllers, with the 95 % interval
    of a share over runs (Wilson's score), where there are `FEW` of them or more.

    Args:
        groups: by the label of the line.
        disturbances: those that at least one of them met are shown.
    """
    lines = {label: _shares(members, disturbances) for label, members in groups.items()}
    selected = [
        disturbance
        for disturbance in disturbances
        if any(disturbance.name in line for line in lines.values())
    ]
    moving = all(disturbance.measure == "moves" for disturbance in selected)
    columns = min(_COLUMNS, len(selected))
    rows = math.ceil(len(selected) / columns)
    figure = new_figure(PAGE_IN, 0.5 + 1.35 * rows)
    axes = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for ax, disturbance in zip(axes.ravel(), selected, strict=False):
        _panel(ax, disturbance, lines)
        unit = disturbance.unit or "× usual" * (
            disturbance.neutral == 1.0 and "/" not in disturbance.label
        )
        unit = f" [{unit}]" if unit else ""
        counts = ", still moving" if disturbance.measure == "moves" and not moving else ""
        ax.set_xlabel(literal_text(disturbance.label + unit + counts))
    for ax in axes.ravel()[len(selected) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel("share that\nstill moves" if moving else "share that keeps\nits gait")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    labels, ncols = list(map(literal_text, labels)), min(len(labels), 5)
    title = "bands: 95 % intervals" if any(ax.collections for ax in axes.ravel()) else None
    figure.legend(handles, labels, loc="outside lower center", ncols=ncols, title=title)
    return figure


Line = Mapping[str, pd.DataFrame]
"""Counts for every disturbance, by level: lanes that retain their gait (`kept`), lanes that had one
(`had`), and their runs (`runs`)."""


def _shares(members: Sequence[Done], disturbances: Sequence[Disturbance]) -> Line:
    tables = [outcome.table.assign(member=i) for i, (_, outcome) in enumerate(members)]
    combined = pd.concat(tables)
    combined["whose"] = combined.groupby(["member", "run"]).ngroup()
    met, line = set(combined["condition"]), {}
    for disturbance in disturbances:
        if disturbance.name in met:
            rows = combined[
                (combined["condition"] == disturbance.name)
                & combined[MEASURES[disturbance.measure]]
            ]
            counts = {"kept": (disturbance.measure, "sum"), "had": (disturbance.measure, "size")}
            line[disturbance.name] = rows.groupby("level").agg(**counts, runs=("whose", "nunique"))
    return line


def _panel(ax: Axes, disturbance: Disturbance, lines: Mapping[str, Line]) -> None:
    for number, (label, line) in enumerate(lines.items()):
        look: Any = {"color": COLOURS[number], "ls": _DASHES[number % len(_DASHES)], "label": label}
        if disturbance.name not in line:
            ax.plot([], [], **look)
            continue
        levels = line[disturbance.name]
        shares = {
            x: share_interval(int(retained), int(had), int(runs))
            for x, retained, had, runs in levels.itertuples()
        }
        shares[disturbance.neutral] = Interval(1.0, low=1.0, high=1.0)  # by definition
        level = sorted(shares)
        ax.plot(
            level, [shares[x].mean for x in level], marker=_MARKERS[number], markersize=2.5, **look
        )
        if max(levels["runs"].tolist(), default=0) >= FEW:
            low, high = [shares[x].low for x in level], [shares[x].high for x in level]
            ax.fill_between(level, low, high, color=look["color"], alpha=0.15, linewidth=0)
    ax.axvline(disturbance.neutral, color="0.6", linewidth=0.6, linestyle=":")
    ax.axhline(0.5, color="0.85", linewidth=0.6, zorder=0)
    if disturbance.neutral == 1.0 and min(disturbance.levels) > 0.0:
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(FixedLocator(_TICKS))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_locator(NullLocator())
    else:
        ax.xaxis.set_major_locator(MaxNLocator(4))
    ax.set_ylim(-0.03, 1.03)
