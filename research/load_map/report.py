"""Statistic, table and figure of the map."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import t as student

from research.frame import markdown_table, write_rows, write_text
from research.load_map.cells import CELLS
from research.load_map.laws import LAWS
from research.load_map.response import response
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled

PLACE = Path(__file__).resolve().parent
ROWS = PLACE / "rows.csv"
GENERATIONS = 40
PAIRS = (("load", "clock"), ("load", "neither"), ("both", "clock"), ("load", "coupled"))
"""Laws that are compared."""
MEANS = {"merit": "merit", "fell": "falls", "speed": "speed", "cost": "CoT",
         "locked": "locked", "lock": "time to lock"}  # fmt: skip
SHADES = {"first": COLOURS[0], "second": COLOURS[4], "tie": "0.45"}
TITLES = {"clock": "clock with balance", "load": "load alone", "coupled": "coupled clock"}
LEVEL = 0.95
"""Level of the intervals, all cells of a map together (Bonferroni)."""


class Gain(NamedTuple):
    """Difference of the merits of two laws in a cell, and its interval."""

    mean: float
    low: float
    high: float

    @property
    def verdict(self) -> str:
        """First or second if the interval is off zero, else a tie."""
        return "first" if self.low > 0.0 else "second" if self.high < 0.0 else "tie"


def gain(rows: pd.DataFrame, first: str, second: str, level: float) -> Gain:
    """Return the merit of one law less that of another in one cell, paired by search and start.

    Its variance is that of the means over searches and that of the means over starts together,
    with the t quantile of the fewer of both.

    Args:
        rows: of one cell and budget.
        first: a law.
        second: another.
        level: of the interval.
    """
    by_law = {law: rows[rows.law == law].sort_values("k") for law in (first, second)}
    variance, fewest, mean = 0.0, np.inf, 0.0
    for column in ("start_merit", "merit"):
        pair = [by_law[law][column].dropna().to_numpy() for law in (first, second)]
        difference = pair[0] - pair[1]
        variance += difference.var(ddof=1) / len(difference)
        fewest, mean = min(fewest, len(difference)), difference.mean()
    half = student.ppf(0.5 + 0.5 * level, fewest - 1) * np.sqrt(variance)
    return Gain(mean, mean - half, mean + half)


def gains(rows: pd.DataFrame, first: str, second: str, generations: int) -> dict[str, Gain]:
    """Return the gains of all cells that have both laws, by name, at the joint level."""
    rows = rows[rows.generations == generations]
    laws = rows.groupby("cell").law.unique()
    names = [cell.name for cell in CELLS if {first, second} <= set(laws.get(cell.name, ()))]
    held_out = {cell.name for cell in CELLS if cell.held_out}
    counts = {held: max(sum((n in held_out) == held for n in names), 1) for held in (False, True)}
    level = {name: 1.0 - (1.0 - LEVEL) / counts[name in held_out] for name in names}
    return {name: gain(rows[rows.cell == name], first, second, level[name]) for name in names}


def report(generations: int = GENERATIONS) -> None:
    """Write table, counts and figure of the page, of the cells that are measured.

    Args:
        generations: the budget.
    """
    rows = with_clock(pd.read_csv(ROWS))
    pairs = {pair: gains(rows, *pair, generations) for pair in PAIRS}
    means = rows[rows.generations == generations].groupby(["cell", "law"])[list(MEANS)].mean()
    lines = [["cell", *LAWS, *(f"{first} − {second}" for first, second in PAIRS)]]
    lock: list[list[object]] = [["cell", "law", *MEANS.values()]]
    gained: list[dict[str, object]] = []
    for name in pairs["load", "clock"]:
        of_cell = {law: means.loc[name, law] for law in LAWS if (name, law) in means.index}
        merits = [f"{of_cell[law].merit:.3f}" if law in of_cell else "–" for law in LAWS]
        found = {pair: of_pair[name] for pair, of_pair in pairs.items() if name in of_pair}
        lines.append([name, *merits, *(_text(found.get(pair)) for pair in PAIRS)])
        lock += [[name, law, *(f"{of_cell[law][title]:.2f}" for title in MEANS)]
                 for law in LAWS if law in of_cell]  # fmt: skip
        gained += [{"cell": name, "first": first, "second": second, **difference._asdict(),
                    "verdict": difference.verdict}
                   for (first, second), difference in found.items()]  # fmt: skip
    write_text(PLACE / "map.md", markdown_table(lines))
    write_text(PLACE / "gaits.md", markdown_table(lock))
    write_rows(PLACE / "gains.csv", gained, digits=4)
    write_rows(PLACE / "convergence.csv", convergence(rows), digits=4)
    left = pd.DataFrame(response(rows, generations))
    write_rows(PLACE / "response.csv", left.to_dict("records"), digits=3)
    with styled():
        save_figure(draw(pairs, means, left), PLACE / "load_map.png")


def convergence(rows: pd.DataFrame) -> list[dict[str, object]]:
    """Return the gain of merit with each doubling of the budget, law by law, of cells with both
    budgets, and how many cells have other verdicts.
    """
    results: list[dict[str, object]] = []
    means = rows.groupby(["cell", "law", "generations"]).merit.mean().unstack()
    for few, many in ((20, 40), (40, 80)):
        if many not in means:
            continue
        change = (means[many] - means[few]).dropna()
        flips = {}
        for budget in (few, many):
            both = change.index.get_level_values("cell").unique()
            of_budget = gains(rows[rows.cell.isin(both)], "load", "clock", budget)
            flips[budget] = {name: difference.verdict for name, difference in of_budget.items()}
        names = flips[few].keys() & flips[many].keys()
        turned = sum({flips[few][n], flips[many][n]} == {"first", "second"} for n in names)
        results += [{"from": few, "to": many, "law": law, "cells": len(group),
                     "median_gain": group.median(), "compared": len(names),
                     "changed": sum(flips[few][n] != flips[many][n] for n in names),
                     "turned": turned}
                    for law, group in change.groupby("law")]  # fmt: skip
    return results


def draw(
    pairs: dict[tuple[str, str], dict[str, Gain]], means: pd.DataFrame, left: pd.DataFrame
) -> Figure:
    """Draw the merit of load over that of the clock, what a coupling of the clocks changes, and
    what strides leave of a slip.
    """
    figure = new_figure(PAGE_IN, 7.4)
    grid = figure.add_gridspec(4, 5)
    plane, bars = figure.add_subplot(grid[:3, :3]), figure.add_subplot(grid[:, 3:])
    load, cells = pairs["load", "clock"], {cell.name: cell for cell in CELLS}
    order = sorted(load, key=lambda name: load[name].mean)
    for place, name in enumerate(order):
        cell, difference = cells[name], load[name]
        shade = SHADES[difference.verdict]
        x, y = means.merit[name, "clock"], means.merit[name, "load"]
        shape = "D" if cell.loses_phase else "o" if cell.walks else "^"
        face = "white" if cell.held_out else shade
        mark: Any = {"marker": shape, "ms": 5, "mec": shade, "mfc": face, "ls": "none"}
        if (name, "coupled") in means.index:
            arrow = {"arrowstyle": "-|>", "color": COLOURS[5], "lw": 0.6, "alpha": 0.6}
            plane.annotate("", (means.merit[name, "coupled"], y), (x, y), arrowprops=arrow)
        plane.plot([x, x], [x + difference.low, x + difference.high], color=shade, lw=0.4)
        plane.plot(x, y, **mark)
        bars.plot([difference.low, difference.high], [place, place], color=shade, lw=0.8)
        bars.plot(difference.mean, place, **mark | {"ms": 3})
    bars.set_yticks(range(len(order)), order, fontsize=5)
    bars.axvline(0.0, color="0.6", lw=0.5)
    bars.set(xlabel="merit of load − merit of clock", ylim=(-1, len(order)))
    top = 0.85
    plane.fill_between([0, top], [0, top], top, color=COLOURS[0], alpha=0.07, lw=0)
    plane.fill_between([0, top], 0, [0, top], color=COLOURS[4], alpha=0.07, lw=0)
    plane.plot([0, top], [0, top], color="0.5", lw=0.6)
    plane.text(0.03, top - 0.03, "load is needed", va="top", color=COLOURS[0], size=13)
    plane.text(top - 0.03, 0.03, "a clock does", ha="right", color=COLOURS[4], size=13)
    plane.set(xlim=(0, top), ylim=(0, top), xlabel="merit of the best clock with balance",
              ylabel="merit of load alone", aspect="equal")  # fmt: skip
    panels = [figure.add_subplot(grid[3, i]) for i in range(3)]
    for panel, law in zip(panels, ("clock", "load", "coupled"), strict=True):
        for strides, group in left[left.law == law].groupby("strides"):
            panel.plot(group.slip, group.left, color=str(0.75 - 0.18 * float(strides)), lw=0.9)
        panel.set(title=TITLES[law], xlim=(-0.5, 0.5), ylim=(-0.5, 0.5), xlabel="slip [cycles]",
                  xticks=(-0.4, 0.0, 0.4), yticks=(-0.4, 0.0, 0.4))  # fmt: skip
    panels[0].set_ylabel("left of it [cycles]")
    return figure


def with_clock(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows in which the clock of a body that cannot tilt is the clock without balance."""
    tilts = rows[rows.law == "clock"].cell.unique()
    single = {cell.name for cell in CELLS if cell.mechanics.limbs == 1}
    level = rows[(rows.law == "neither") & ~rows.cell.isin(tilts) & rows.cell.isin(single)]
    return pd.concat([rows, level.assign(law="clock")])


def _text(difference: Gain | None) -> str:
    if difference is None:
        return "–"
    return f"{difference.mean:+.2f} [{difference.low:+.2f}, {difference.high:+.2f}]"
