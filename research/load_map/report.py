"""Statistic, table and figure of the map."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import t as student

from research.frame import markdown_table, write_text
from research.load_map.cells import CELLS

PLACE = Path(__file__).resolve().parent
ROWS = PLACE / "rows.csv"
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


def report(generations: int = 40) -> None:
    """Write the table of the page.

    Args:
        generations: the budget.
    """
    rows = pd.read_csv(ROWS)
    rows = with_clock(rows)
    load, joint = (gains(rows, law, "clock", generations) for law in ("load", "both"))
    lines = [["cell", "load", "clock with balance", "both", "neither", "load − clock",
              "both − clock"]]  # fmt: skip
    means = rows[rows.generations == generations].groupby(["cell", "law"]).merit.mean()
    for name, difference in load.items():
        merits = [f"{means.get((name, law), np.nan):.3f}" for law in
                  ("load", "clock", "both", "neither")]  # fmt: skip
        texts = [_text(difference), _text(joint[name]) if name in joint else "–"]
        lines.append([name, *merits, *texts])
    write_text(PLACE / "map.md", markdown_table(lines))


def with_clock(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows in which the clock of a body that cannot tilt is the clock without balance."""
    tilts = rows[rows.law == "clock"].cell.unique()
    level = rows[(rows.law == "neither") & ~rows.cell.isin(tilts)]
    return pd.concat([rows, level.assign(law="clock")])


def _text(difference: Gain) -> str:
    return f"{difference.mean:+.3f} [{difference.low:+.3f}, {difference.high:+.3f}]"
