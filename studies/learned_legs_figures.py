"""The pictures of the study of learned feedback on legs."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from learned_legs_plan import TABLES
from tegotae.figures.gaits.colours import gait_colour, gait_marker
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.statistics import interval

Rows = dict[str, np.ndarray]

FAMILIES = {
    "V": ("V", "#000000", "-"),
    "cos": ("cosine law", "0.5", "--"),
    "VG-gF": ("VG", COLOURS[3], "-"),
    "AR-rF": ("AR", COLOURS[0], "-"),
    "ARG-rF-gF": ("ARG", COLOURS[5], "-"),
    "ART-rF-t+phif": ("ART, T added", COLOURS[4], "-"),
    "ARGT-rF-gF-t+phif": ("ARGT, T added", COLOURS[6], "-"),
    "ART-rF-tphif": ("ART", COLOURS[1], "-"),
    "ARGT-rF-gF-tphif": ("ARGT", COLOURS[7], "-"),
    "Wphi-F": ("whole body, clock", COLOURS[1], ":"),
    "W-Fa": ("whole body", COLOURS[6], ":"),
    "T-F": ("T a leg, no oscillator", COLOURS[3], ":"),
}
"""What families are called in pictures, and how they are drawn."""


def draw_all(curves: Rows, judged: Rows, over: Rows, shares: Rows) -> None:
    """Draw and write all."""
    with styled():
        save_figure(draw_curves(curves), TABLES / "convergence.png")
        save_figure(draw_families(judged), TABLES / "families.png")
        save_figure(draw_range(over), TABLES / "range.png")
        save_figure(draw_shares(shares, judged), TABLES / "disturbed.png")


def family(cell: str) -> str:
    """The family of a cell's name."""
    return cell.partition("@")[0]


def draw_curves(curves: Rows) -> Figure:
    """Best fitness so far over the generations: the median run, and from the worst to the best."""
    figure = new_figure(PAGE_IN, 2.6)
    bodies = ("quadruped-c", "plate-light-pitch")
    for axes, body in zip(figure.subplots(1, 2), bodies, strict=True):
        for name, (label, colour, line) in FAMILIES.items():
            mine = curves["cell"] == f"{name}@{body}"
            if not mine.any():
                continue
            generations = np.unique(curves["generation"][mine])
            runs = np.array(
                [curves["best_fitness"][mine & (curves["generation"] == g)] for g in generations]
            )
            if len(generations) == 1:
                axes.axhline(runs[0, 0], color=colour, ls="--", lw=0.8, label=label)
                continue
            axes.plot(generations, np.median(runs, axis=1), line, color=colour, label=label)
            axes.fill_between(generations, runs.min(1), runs.max(1), color=colour, alpha=0.12, lw=0)
        axes.set_title(body)
        axes.set_xlabel("generation")
        axes.set_ylim(*((-8.0, 7.0) if body == "quadruped-c" else (0.4, 0.9)))
    figure.axes[0].set_ylabel("best fitness so far")
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        handles |= {t: h for h, t in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=6)
    return figure


def draw_families(judged: Rows) -> Figure:
    """Cost of transport, speed and time to lock of every run of the quadruped at ω 2."""
    figure = new_figure(PAGE_IN, 2.5)
    shown = [name for name in FAMILIES if f"{name}@quadruped-c" in set(judged["cell"])]
    titles = {
        "cost_of_transport": "cost of transport",
        "speed_m_per_s": "speed [√(g l0)]",
        "lock_time_s": "time to lock [√(l0/g)]",
        "upright": "share upright",
    }
    for axes, (column, title) in zip(
        figure.subplots(1, 4, sharey=True), titles.items(), strict=True
    ):
        for row, name in enumerate(shown):
            mine = judged["cell"] == f"{name}@quadruped-c"
            most = 1.0 if column == "upright" else np.inf
            dots(axes, judged[column][mine], judged["gait"][mine], row, most)
        axes.set_xlabel(title)
        axes.set_yticks(range(len(shown)), [FAMILIES[name][0] for name in shown])
        axes.grid(axis="x", lw=0.3, alpha=0.5)
    figure.axes[0].invert_yaxis()
    figure.axes[0].set_xscale("log")
    figure.axes[0].set_xlim(left=0.1)
    figure.axes[1].axvline(0.8 / np.pi, color="0.6", lw=0.6, ls="--")
    seen = dict.fromkeys(judged["gait"][np.char.endswith(judged["cell"], "@quadruped-c")].tolist())
    for name in seen:
        figure.axes[0].plot([], [], gait_marker(name), color=gait_colour(name), ms=4, label=name)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6)
    return figure


def dots(axes: Axes, values: np.ndarray, gaits: np.ndarray, row: float, most: float) -> None:
    """Every run by the marker of its gait, and the mean with its interval."""
    for at, (value, gait) in enumerate(zip(values, gaits, strict=True)):
        off = 0.5 * (at - 0.5 * (len(values) - 1)) / max(len(values), 1)
        axes.plot(value, row + off, gait_marker(gait), color=gait_colour(gait), ms=3.5)
    found = interval(values, within=(0.0, most))
    if found.count > 2:
        axes.plot([found.low, found.high], [row, row], "-", color="0.3", lw=0.8, zorder=0)


def draw_range(over: Rows) -> Figure:
    """Speed and cost of transport over the frequency, of controllers trained at ω 2."""
    figure = new_figure(PAGE_IN, 2.6)
    left, right = figure.subplots(1, 2)
    for name in ("V", "cos", "AR-rF", "ARG-rF-gF", "ART-rF-t+phif", "ART-rF-tphif", "Wphi-F"):
        mine = over["cell"] == f"{name}@quadruped-c"
        if not mine.any():
            continue
        label, colour, line = FAMILIES[name]
        omegas = np.unique(over["omega"][mine])
        for axes, column in ((left, "speed_m_per_s"), (right, "cost_of_transport")):
            values = [over[column][mine & (over["omega"] == omega)] for omega in omegas]
            middle = [np.nanmedian(x) if np.isfinite(x).any() else np.nan for x in values]
            axes.plot(omegas, middle, line, color=colour, marker="o", ms=2.5, label=label)
    nominal = np.array([0.5, 4.0])
    left.plot(nominal, 0.4 * nominal / np.pi, color="0.7", lw=0.6, ls="--")
    left.set_ylabel("speed [√(g l0)]")
    right.set_ylabel("cost of transport")
    right.set_yscale("log")
    for axes in (left, right):
        axes.axvline(2.0, color="0.8", lw=0.6)
        axes.set_xlabel("frequency ω [√(g/l0)]")
    figure.legend(*left.get_legend_handles_labels(), loc="outside right center")
    return figure


def draw_shares(shares: Rows, judged: Rows) -> Figure:
    """How much a body still gets for its work under every disturbance, falls counted as nothing."""
    figure = new_figure(PAGE_IN, 4.8)
    conditions = [c for c in dict.fromkeys(shares["condition"].tolist()) if c != "lost-leg"]
    grid = figure.subplots(-(-len(conditions) // 4), 4, sharey=True).ravel()
    neutral = {"omega": 1.0, "mass": 1.0, "friction": 1.0, "inertia": 1.0}
    for axes, condition in zip(grid, conditions, strict=False):
        for cell in dict.fromkeys(shares["controller"].tolist()):
            mine = (shares["controller"] == cell) & (shares["condition"] == condition)
            if not mine.any():
                continue
            label, colour, line = FAMILIES[family(cell)]
            usual = 1.0 / np.nanmedian(judged["cost_of_transport"][judged["cell"] == cell])
            level = np.append(shares["level"][mine], neutral.get(condition, 0.0))
            kept = np.nan_to_num(shares["efficiency"][mine]) * shares["moves"][mine]
            gets = usual * np.append(kept, 1.0)
            order = np.argsort(level)
            axes.plot(level[order], gets[order], line, color=colour, ms=2, marker="o", label=label)
        axes.set_xlabel(condition)
    grid[0].set_ylim(0.0, 10.0)
    for axes in grid[len(conditions) :]:
        axes.set_axis_off()
    for axes in grid[::4]:
        axes.set_ylabel("CoT⁻¹ × walking")
    figure.legend(*grid[0].get_legend_handles_labels(), loc="outside lower center", ncols=6)
    return figure
