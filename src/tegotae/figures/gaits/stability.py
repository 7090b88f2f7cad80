"""Multipliers of gaits along a parameter: where deviations of lags begin to grow."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.gaits.stability import GaitStability, StabilityBranch
from tegotae.figures.gaits.colours import gait_colour, gait_marker
from tegotae.figures.gaits.labels import label
from tegotae.figures.style import COLUMN_IN, new_figure, styled


def stability_figure(found: GaitStability, note: str = "") -> Figure:
    """Above the moduli of all multipliers, the largest filled; below what the fit leaves over.

    Lines join the largest ones. A cross marks where the largest multiplier crosses one. In between,
    a row a gait, are the values at which the body, unkicked, stays in it to the end.

    Args:
        found: the return maps.
        note: the title.
    """
    with styled():
        rows = 0.12 * len(found.branches)
        figure = new_figure(COLUMN_IN, 3.4 + rows)
        moduli, stays, residual = figure.subplots(
            3, 1, sharex=True, height_ratios=(2.4, 0.9 * rows, 1.0)
        )
        values = np.array(found.over.values)
        _stays(stays, values, found)
        moduli.axhline(1.0, color="0.6", lw=0.6, zorder=0)
        for branch in found.branches:
            if np.isfinite(branch.largest).any():
                _moduli(moduli, values, branch)
                shown = [each.residual for each in branch.maps]
                _line(residual, values, shown, branch.gait)
        for each in found.crossings:
            moduli.plot(each.at, 1.0, "x", color="k", ms=5, mew=0.8, zorder=3)
        moduli.set_ylabel("|multipliers| per cycle")
        moduli.set_ylim(bottom=0.0)
        moduli.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, title=note or None)
        residual.set(ylim=(0.0, 1.0), ylabel="unexplained")
        residual.set_xlabel(label(found.over, found.legged))
        residual.set_xlim(values[0], values[-1])
    return figure


def _moduli(axes: Axes, values: np.ndarray, branch: StabilityBranch) -> None:
    colour, marker = gait_colour(branch.gait), gait_marker(branch.gait)
    _line(axes, values, branch.largest, branch.gait)
    for each in np.abs([m.multipliers for m in branch.maps]).T[1:]:
        axes.plot(values, each, marker, color=colour, ms=2.6, mew=0.5, fillstyle="none")


def _stays(axes: Axes, values: np.ndarray, found: GaitStability) -> None:
    for row, branch in enumerate(found.branches):
        there = values[branch.stays]
        axes.plot(
            there,
            np.full(there.size, row),
            "s",
            color=gait_colour(branch.gait),
            ms=3,
            clip_on=False,
        )
    axes.set(ylim=(len(found.branches) - 0.4, -0.6), yticks=[])
    axes.set_ylabel("stays", rotation=0, ha="right", va="center")
    axes.tick_params(axis="x", length=0)


def _line(axes: Axes, values: np.ndarray, shown: object, gait: str) -> None:
    colour, marker = gait_colour(gait), gait_marker(gait)
    axes.plot(values, np.asarray(shown), marker + "-", color=colour, ms=3, lw=0.8, label=gait)
