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
    """Return the gains of all cells that have both laws, by name, at the joint level.

    Args:
        rows: of judged controllers.
        first: a law.
        second: another.
        generations: the budget.
    """
    groups = dict(iter(rows[rows.generations == generations].groupby("cell")))
    names = [c for c in CELLS if {first, second} <= set(groups.get(c.name, rows[:0]).law)]
    number = {held: sum(cell.held_out == held for cell in names) for held in (False, True)}
    level = {held: 1.0 - (1.0 - LEVEL) / max(number[held], 1) for held in number}
    return {c.name: gain(groups[c.name], first, second, level[c.held_out]) for c in names}


def report() -> None:
    """Write table and figure of the page, of the cells that are measured."""
    rows = pd.read_csv(ROWS)
    level = rows[(rows.law == "neither") & rows.cell.str.startswith("hopper")]
    rows = pd.concat([rows, level.assign(law="clock")])  # what cannot tilt needs no balance
    pairs = {(budget, *pair): gains(rows, *pair, budget)
             for budget in (20, GENERATIONS, 80) for pair in PAIRS}  # fmt: skip
    differences = [{"cell": name, "first": first, "second": second, "generations": budget,
               **difference._asdict(), "verdict": difference.verdict}
              for (budget, first, second), of_pair in pairs.items()
              for name, difference in of_pair.items()]  # fmt: skip
    write_rows(PLACE / "gains.csv", differences, digits=4)
    rows = rows[rows.generations == GENERATIONS]
    merit = rows.groupby(["cell", "law"]).merit.mean()
    names = [*pairs[GENERATIONS, "load", "clock"]]
    merits = [[name, *(f"{merit.get((name, law), np.nan):.2f}" for law in LAWS)] for name in names]
    gained = [[name, *(_text(pairs[GENERATIONS, *p].get(name)) for p in PAIRS)] for name in names]
    heads = [["cell", *LAWS], ["cell", *(f"{first} − {second}" for first, second in PAIRS)]]
    tables = [markdown_table([heads[0], *merits]), markdown_table([heads[1], *gained])]
    write_text(PLACE / "map.md", "\n".join(tables).replace("nan", "–"))
    slips = pd.DataFrame(response(rows))
    write_rows(PLACE / "response.csv", slips.to_dict("records"), digits=3)
    with styled():
        save_figure(draw(pairs[GENERATIONS, "load", "clock"], merit, slips), PLACE / "load_map.png")


def draw(load: dict[str, Gain], merit: Any, slips: pd.DataFrame) -> Figure:
    """Draw the merit of load over that of the clock, what a coupling of the clocks changes, and
    what strides leave of a slip.

    Args:
        load: gains of load over the clock, by cell.
        merit: means by cell and law.
        slips: rows of `response`.
    """
    figure = new_figure(PAGE_IN, 7.0)
    grid = figure.add_gridspec(4, 5)
    plane, bars = figure.add_subplot(grid[:3, :3]), figure.add_subplot(grid[:, 3:])
    cells = {cell.name: cell for cell in CELLS}
    order = sorted(load, key=lambda name: load[name].mean)
    for place, name in enumerate(order):
        cell, difference = cells[name], load[name]
        shade = SHADES[difference.verdict]
        x, y = merit[name, "clock"], merit[name, "load"]
        shape = "D" if cell.loses_phase else "o" if cell.walks else "^"
        face = "white" if cell.held_out else shade
        mark: Any = {"marker": shape, "ms": 5, "mec": shade, "mfc": face, "ls": "none"}
        if (name, "coupled") in merit.index:
            arrow = {"arrowstyle": "-|>", "color": COLOURS[5], "lw": 0.6, "alpha": 0.6}
            plane.annotate("", (merit[name, "coupled"], y), (x, y), arrowprops=arrow)
        ends = [x + difference.low, x + difference.high]
        plane.plot([x, x], ends, color=shade, lw=0.5, alpha=0.4, zorder=1)
        plane.plot(x, y, **mark)
        bars.plot([difference.low, difference.high], [place, place], color=shade, lw=0.8)
        bars.plot(difference.mean, place, **mark | {"ms": 3})
    bars.set_yticks(range(len(order)), order, fontsize=5)
    bars.axvline(0.0, color="0.6", lw=0.5)
    bars.set(xlabel="merit of load − merit of clock", ylim=(-1, len(order)))
    top = 0.92
    plane.fill_between([0, top], [0, top], top, color=COLOURS[0], alpha=0.07, lw=0)
    plane.fill_between([0, top], 0, [0, top], color=COLOURS[4], alpha=0.07, lw=0)
    plane.plot([0, top], [0, top], color="0.5", lw=0.6)
    box = {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}
    plane.text(0.03, 0.87, "load is needed", color=COLOURS[0], size=13, bbox=box)
    plane.text(0.03, 0.83, "arrows: with the clocks coupled", color=COLOURS[5], bbox=box)
    plane.text(0.89, 0.03, "a clock does", ha="right", color=COLOURS[4], size=13)
    plane.set(xlim=(0, top), ylim=(0, top), xlabel="merit of the best clock with balance",
              ylabel="merit of load alone")  # fmt: skip
    panels = [figure.add_subplot(grid[3, i]) for i in range(3)]
    for panel, law in zip(panels, TITLES, strict=True):
        for strides, group in slips[slips.law == law].groupby("strides"):
            panel.plot(group.slip, group.remaining, color=str(0.75 - 0.18 * float(strides)), lw=0.9,
                       label=f"{strides}")  # fmt: skip
        panel.set(title=TITLES[law], xlim=(-0.5, 0.5), ylim=(-0.5, 0.5), xlabel="slip [cycles]",
                  xticks=(-0.4, 0.0, 0.4), yticks=(-0.4, 0.0, 0.4))  # fmt: skip
    panels[0].set_ylabel("left of it [cycles]")
    panels[1].legend(title="strides after", loc="upper left", fontsize=5, title_fontsize=5)
    return figure


def _text(difference: Gain | None) -> str:
    if difference is None:
        return "–"
    return f"{difference.mean:+.2f} [{difference.low:+.2f}, {difference.high:+.2f}]"
