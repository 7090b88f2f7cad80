"""The atlas of learned controllers in a figure: what is left without feedback, and short forms."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.reproduction.learning.atlas import KINDS, NETWORK, forms_by_numbers
from research.reproduction.learning.forms import leg_controller
from research.reproduction.learning.runs import where
from tegotae.analysis.short_forms import SHARES
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled

_COLOURS = dict(zip(KINDS[:-1], ("#bbbbbb", *COLOURS[1:]), strict=False))


def atlas_figure(runs: pd.DataFrame) -> Figure:
    """Draw one row per training frequency: merit over its remainder without the feedback, one point
    per run, and the share of controllers that forms of a number of parameters replace.

    Args:
        runs: of `research.reproduction.learning.atlas.measure_atlas`.
    """
    omegas = sorted(runs.omega_t.dropna().unique())
    with styled():
        figure = new_figure(PAGE_IN, 2.9 * len(omegas))
        panels = figure.subplots(len(omegas), 2, squeeze=False, width_ratios=(3, 2))
        for (left, right), omega in zip(panels, omegas, strict=True):
            group = where(runs, runs.omega_t == omega)
            _draw_cut(left, group)
            _replaced(right, group)
            left.set(title=f"$\\omega_t$ = {omega:g} rad/s", ylabel="merit [m/J]")
        panels[-1][0].set(xlabel="what is left of it with the feedback cut")
        panels[-1][1].set(xlabel="numbers of the form")
        labels, handles = panels[0][0].get_legend_handles_labels()[::-1]
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        return figure


def _draw_cut(axes: Axes, runs: pd.DataFrame) -> None:
    for kind in KINDS[1:-1]:
        group = where(runs, runs.kind == kind)
        share = np.clip(group.merit_cut / group.merit, 0.0, 1.2)
        axes.scatter(share, group.merit, 7, color=_COLOURS[kind], alpha=0.6, lw=0, label=kind)
    axes.set(xlim=(-0.03, 1.23), ylim=(0.0, None))


def _replaced(axes: Axes, runs: pd.DataFrame) -> None:
    best = where(runs, runs.best & ~runs.kind.isin([KINDS[0], NETWORK]))
    numbers = {name: leg_controller(name).n_weights for name in forms_by_numbers()}
    counts = range(min(numbers.values()), max(numbers.values()) + 1)
    for share, line in zip(SHARES, (":", "--", "-"), strict=True):
        replaced = [
            (best[[f"kept {name}" for name in numbers if numbers[name] <= n]].max(axis=1) >= share)
            for n in counts
        ]
        means = [float(x.mean()) for x in replaced]
        axes.plot(
            counts, means, line, color="black", marker=".", lw=1.0, label=f"keeps {share:.0%}"
        )
    axes.set(ylim=(0.0, 1.02), ylabel="share of controllers")
    axes.legend(loc="lower right")
