"""Tables in Markdown and figures of the study of learned feedback on legs."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pandas as pd

from research.frame import markdown_table
from research.learned_legs.evaluate import CONDITIONS, selected
from research.learned_legs.figures import draw_all
from research.learned_legs.plan import CELLS, RANGE, TABLES, advance_m_per_rad, baseline_cost
from tegotae._support.files import write_atomically
from tegotae.measures.statistics import UNBOUNDED, Range, interval

ADVANCE = advance_m_per_rad(RANGE[0].design)
"""The way per radian of the command that is wanted [m/rad]."""

STANDS = 0.75
"""A run that misses the wanted speed by so much of it, at any command, does not walk there."""


def report() -> None:
    """Write the tables and all figures from the tables that are there."""
    judged, rows, disturbed, curves = map(table, ("judged", "range", "disturbed", "curves"))
    texts = {
        "range": by_family(rows, disturbed),
        "chosen": by_command(rows, "ART-rF-t+phif+range@quadruped-c"),
        "robust": robust(rows, disturbed),
        "convergence": convergence(curves),
        "hexapod": summary(judged, curves, "@hexapod"),
        "plate": summary(judged, curves, "@plate-light-pitch"),
    }
    for name, text in texts.items():
        write_atomically(TABLES / f"{name}.md", text)
    draw_all(curves, rows)


def table(name: str) -> pd.DataFrame:
    """Return a table of the study."""
    return pd.read_csv(TABLES / f"{name}.csv", dtype={"run": str})


SHARE, POSITIVE = (0.0, 1.0), (0.0, np.inf)


def sure(values: np.ndarray | pd.Series, digits: int = 2, within: Range = UNBOUNDED) -> str:
    """Return a mean and its 95 % interval."""
    estimate = interval(np.asarray(values), within=within)
    if np.isnan(estimate.mean):
        return "–"
    mean = f"{estimate.mean:.{digits}f}"
    if np.isnan(estimate.low) or estimate.count < 3:
        return mean
    return f"{mean} ({estimate.low:.{digits}f} … {estimate.high:.{digits}f})"


def grids(rows: pd.DataFrame, cell: str) -> dict[str, pd.DataFrame]:
    """Return the columns of a cell as [runs, commands], with the shares of the front's cost and of
    the wanted speed that is missed.
    """
    rows = rows[rows.cell == cell]
    share = rows.cost_of_transport / baseline_cost(rows.speed_m_per_s.to_numpy())
    off = abs(rows.speed_m_per_s / (ADVANCE * rows.omega) - 1.0)
    rows = rows.assign(share=share, off=off)
    names = rows.columns.difference(["cell", "run", "omega", "condition"])
    return {name: rows.pivot(index="run", columns="omega", values=name) for name in names}


def preserved(rows: pd.DataFrame, disturbed: pd.DataFrame, cell: str) -> dict[str, pd.Series]:
    """Return the share of CoT⁻¹ that each run keeps under each condition, at its worst command;
    [runs].

    A release that falls keeps nothing.
    """
    cost, worst = grids(rows, cell)["cost_of_transport"], {}
    for name in CONDITIONS:
        under = grids(disturbed[disturbed.condition == name], cell)
        worst[name] = (under["upright"] * cost / under["cost_of_transport"]).fillna(0.0).min(axis=1)
    return worst


def by_family(rows: pd.DataFrame, disturbed: pd.DataFrame) -> str:
    """Return one row per family: means of the runs over all commands, and the selected run at its
    worst.

    The cost of transport is of the runs that walk: it has no bound where a body stands.
    """
    titles = ("family", "numbers", "upright; runs that walk", "locked", "speed off by")
    lines = [[*titles, "of the front", "at worst", "selected run: mean, worst, locked"]]
    for cell in RANGE:
        numbers, chosen = grids(rows, cell.name), selected(cell.name)
        walks = (numbers["off"] < STANDS).all(axis=1)
        share, locked = numbers["share"][walks].to_numpy(), numbers["locked"]
        best = numbers["share"].loc[chosen]
        lines.append(
            [
                f"`{cell.name.partition('@')[0]}`",
                str(cell.experiment.controller.n_weights),
                f"{sure(numbers['upright'].mean(axis=1), 2, SHARE)}; {walks.sum()} of {len(walks)}",
                sure(locked.mean(axis=1), 2, SHARE),
                sure(numbers["off"].mean(axis=1, skipna=False), 2, POSITIVE),
                sure(share.mean(axis=1), 2, POSITIVE),
                sure(share.max(axis=1), 2, POSITIVE),
                f"{chosen}: {best.mean():.2f}, {best.max():.2f}, {locked.loc[chosen].min():.2f}",
            ]
        )
    return markdown_table(lines)


def by_command(rows: pd.DataFrame, cell: str) -> str:
    """Return the selected run of a cell at every command, with the range of all runs beside it."""
    numbers, chosen = grids(rows, cell), selected(cell)
    titles = ("ω", "wanted speed", "speed", "CoT", "of the front", "all runs", "locked", "gait")
    lines = [[*titles]]
    for omega in numbers["share"]:
        row = {name: grid[omega][chosen] for name, grid in numbers.items()}
        lines.append(
            [
                f"{omega:g}",
                f"{ADVANCE * omega:.3f}",
                f"{row['speed_m_per_s']:.3f}",
                f"{row['cost_of_transport']:.3f}",
                f"{row['share']:.2f}",
                sure(numbers["share"][omega], 2, POSITIVE),
                f"{row['locked']:.2f}, in {row['lock_time_s']:.0f}",
                row["gait"],
            ]
        )
    return markdown_table(lines)


def robust(rows: pd.DataFrame, disturbed: pd.DataFrame) -> str:
    """Return the share of CoT⁻¹ that disturbances leave at the worst command: of all runs, and of
    the selected one."""
    lines = [["family", *CONDITIONS]]
    for cell in RANGE:
        cells = [
            f"{sure(shares, 2, POSITIVE)}; {shares[selected(cell.name)]:.2f}"
            for shares in preserved(rows, disturbed, cell.name).values()
        ]
        lines.append([f"`{cell.name.partition('@')[0]}`", *cells])
    return markdown_table(lines)


def summary(judged: pd.DataFrame, curves: pd.DataFrame, ending: str) -> str:
    """Return one row per family of one frequency: fitness, and the gait from random phases."""
    walk = () if "plate" in ending else ("speed", "CoT")
    titles = ("family, numbers", "fitness", "upright", "locked", "locks in", *walk, "gait")
    lines = [[*titles]]
    for cell in (cell for cell in CELLS if cell.name.endswith(ending)):
        mine = judged[judged.cell == cell.name]
        walking = [sure(mine.speed_m_per_s, 3), sure(mine.cost_of_transport, 2, POSITIVE)]
        lines.append(
            [
                f"`{cell.name.partition('@')[0]}`, {cell.experiment.controller.n_weights}",
                sure(np.array([fitness[-1] for _, fitness in of_runs(curves, cell.name)])),
                sure(mine.upright, within=SHARE),
                sure(mine.locked, within=SHARE),
                sure(mine.lock_time_s, 0, POSITIVE),
                *(walking if walk else ()),
                ", ".join(f"{name} {count}" for name, count in Counter(mine.gait).most_common()),
            ]
        )
    return markdown_table(lines)


def of_runs(curves: pd.DataFrame, cell: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the generations and best fitness so far of every run of a cell."""
    runs = curves[curves.cell == cell].groupby("seed")
    return [(run.generation.to_numpy(), run.best_fitness.to_numpy()) for _, run in runs]


def convergence(curves: pd.DataFrame) -> str:
    """Return the best fitness after a half, two thirds and all of the training of each run."""
    lines = [["cell", "generations", "half", "two thirds", "all"]]
    for cell in (cell for cell in CELLS if not cell.experiment.is_searched):
        runs = of_runs(curves, cell.name)
        shares = [
            np.array([np.interp(share * g[-1], g, fitness) for g, fitness in runs])
            for share in (0.5, 2.0 / 3.0, 1.0)
        ]
        lengths = sorted({int(g[-1]) for g, _ in runs})
        length = " to ".join(f"{x}" for x in dict.fromkeys((lengths[0], lengths[-1])))
        lines.append([f"`{cell.name}`", length, *map(sure, shares)])
    return markdown_table(lines)
