"""The pictures of the study of learned feedback on legs."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.learned_legs.evaluate import selected
from research.learned_legs.plan import RANGE, TABLES, baseline, baseline_cost
from research.legs_limit.known import limit
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled

FAMILIES = {
    "V": ("V, one σ", "#000000", ":"),
    "cos": ("cosine law", "0.5", "--"),
    "load": ("σN, with a place", "0.7", "-."),
    "latch": ("latch", COLOURS[7], "--"),
    "decay": ("decay", COLOURS[6], "--"),
    "decay-t": ("decay and ellipse", COLOURS[2], "--"),
    "VG-gF": ("VG", COLOURS[3], "-"),
    "AR-rF": ("AR", COLOURS[0], "-"),
    "ARG-rF-gF": ("ARG", COLOURS[5], "-"),
    "ART-rF-t+phif": ("ART, T added", COLOURS[4], "-"),
    "W+phi-F": ("whole body, clock and ellipses", COLOURS[1], "-"),
}
"""Labels and styles of families in pictures."""


def draw_all(curves: pd.DataFrame, rows: pd.DataFrame) -> None:
    """Draw and write all."""
    with styled():
        save_figure(draw_range(rows), TABLES / "range.png")
        save_figure(draw_curves(curves), TABLES / "convergence.png")


def families() -> list[tuple[str, tuple[str, str, str]]]:
    """Return the names of the cells, and how their families are drawn."""
    return [(cell.name, FAMILIES[cell.name.partition("+range")[0]]) for cell in RANGE]


def draw_range(rows: pd.DataFrame) -> Figure:
    """Draw cost over speed of the selected runs beside front and limit; their share of the
    front.
    """
    figure = new_figure(PAGE_IN, 3.2)
    left_axes, right_axes = figure.subplots(1, 2)
    left_axes.plot(*baseline(), color="black", lw=1.6, label="vanilla front")
    speeds = np.linspace(0.1, 0.65, 56)
    left_axes.plot(
        speeds,
        limit(speeds, "ellipse"),
        color="black",
        ls="--",
        lw=1.2,
        label="limit, this ellipse",
    )
    left_axes.plot(speeds, limit(speeds), color="black", ls=":", lw=1.0, label="limit, free feet")
    for name, (label, colour, line) in families():
        mine = rows["cell"] == name
        mask = mine & (rows["run"] == selected(name))
        speed, cost = rows["speed_m_per_s"], rows["cost_of_transport"]
        left_axes.plot(speed[mask], cost[mask], line, color=colour, marker="o", ms=2.5, label=label)
        share = cost / baseline_cost(speed)
        right_axes.plot(rows["omega"][mask], share[mask], line, color=colour, marker="o", ms=2.5)
        if line == "-":  # of short laws some runs do not walk
            _band(right_axes, rows["omega"][mine], share[mine], colour)
    right_axes.axhline(1.0, color="black", lw=1.0)
    right_axes.axhline(0.6, color="0.6", lw=0.6, ls="--")
    left_axes.set_yscale("log")
    right_axes.set_yscale("log")
    ticks = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 1.0, 2.0)
    for axes, lower in ((left_axes, 0.02), (right_axes, 0.14)):
        axes.set_ylim(lower, 2.5)
        visible = [tick for tick in ticks if tick >= lower]
        axes.set_yticks(visible, [f"{tick:g}" for tick in visible])
        axes.minorticks_off()
    left_axes.set_xlim(0.0, 0.65)
    left_axes.set_xlabel("speed [√(g l0)]")
    left_axes.set_ylabel("cost of transport")
    right_axes.set_xlabel("command ω [√(g/l0)]")
    right_axes.set_ylabel("share of the front at that speed")
    handles, labels = left_axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _band(axes: Axes, omega: pd.Series, share: pd.Series, colour: str) -> None:
    """Fill the band from the lower to the upper quartile of the runs."""
    commands = np.unique(omega)
    low, high = (
        [np.nanquantile(share[omega == x], quantile) for x in commands] for quantile in (0.25, 0.75)
    )
    axes.fill_between(commands, low, high, color=colour, alpha=0.12, lw=0)


def draw_curves(curves: pd.DataFrame) -> Figure:
    """Draw the best fitness so far over the generations: the median run, and from the worst to
    the best.
    """
    figure = new_figure(PAGE_IN, 2.8)
    axes = figure.subplots()
    for name, (label, colour, line) in families():
        mine = curves[curves.cell == name]
        generations = np.unique(mine.generation)
        if len(generations) == 1:
            axes.axhline(mine.best_fitness.iloc[0], color=colour, ls=line, label=label)
            continue
        runs = np.array(
            [np.interp(generations, run.generation, run.best_fitness)
             for _, run in mine.groupby("seed")]
        )  # fmt: skip
        # Of a run that has ended the last fitness stays.
        axes.plot(generations, np.median(runs, axis=0), line, color=colour, label=label)
        axes.fill_between(generations, runs.min(0), runs.max(0), color=colour, alpha=0.12, lw=0)
    axes.set_xlabel("generation")
    axes.set_ylabel("best fitness so far")
    axes.set_ylim(-1.5, 1.8)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")
    return figure
