"""Tables in Markdown and figures of the study of learned feedback on legs."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from research.frame import markdown_table
from research.learned_legs.evaluate import CONDITIONS, selected
from research.learned_legs.figures import draw_all
from research.learned_legs.plan import CELLS, RANGE, TABLES, Cell, advance_m_per_rad, baseline_cost
from tegotae._support.files import write_atomically
from tegotae._support.tables import read_csv
from tegotae.measures.statistics import UNBOUNDED, Range, interval

Rows = dict[str, np.ndarray]
ADVANCE = advance_m_per_rad(RANGE[0].design)
"""The way per radian of the command that is wanted [m/rad]."""

STANDS = 0.75
"""A run that misses the wanted speed by so much of it, at any command, does not walk there."""


def report() -> None:
    """Write the tables and all figures from the tables that are there."""
    tables = {name: table(name) for name in ("judged", "range", "disturbed", "curves")}
    rows = tables["range"]
    texts = {
        "range": by_family(rows, tables["disturbed"]),
        "chosen": by_command(rows, "ART-rF-t+phif+range@quadruped-c"),
        "robust": robust(rows, tables["disturbed"]),
        "convergence": convergence(tables["curves"]),
        "hexapod": summary(tables["judged"], tables["curves"], "@hexapod"),
        "plate": summary(tables["judged"], tables["curves"], "@plate-light-pitch"),
    }
    for name, text in texts.items():
        if text:
            write_atomically(TABLES / f"{name}.md", text)
    draw_all(tables["curves"], rows)


def table(name: str) -> Rows:
    """Return a table of the study as columns, as numbers where all are."""
    rows = read_csv(TABLES / f"{name}.csv")
    return {title: _numbers(column) for title, column in rows.items()}


def _numbers(column: Any) -> np.ndarray:
    cells = [str(cell) for cell in column]
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def markdown(titles: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a table as Markdown."""
    return markdown_table([titles, *rows]) if rows else ""


SHARE, POSITIVE = (0.0, 1.0), (0.0, np.inf)


def sure(values: np.ndarray, digits: int = 2, within: Range = UNBOUNDED) -> str:
    """Return a mean and its 95 % interval."""
    estimate = interval(values, within=within)
    if np.isnan(estimate.mean):
        return "–"
    mean = f"{estimate.mean:.{digits}f}"
    if np.isnan(estimate.low) or estimate.count < 3:
        return mean
    return f"{mean} ({estimate.low:.{digits}f} … {estimate.high:.{digits}f})"


def per_run(rows: Rows, cell: str) -> dict[str, dict[str, np.ndarray]]:
    """Return for every run of a cell its columns over the commands, and its share of the front."""
    runs = {}
    for run in dict.fromkeys(rows["run"][rows["cell"] == cell].tolist()):
        mask = (rows["cell"] == cell) & (rows["run"] == run)
        columns = {name: column[mask] for name, column in rows.items()}
        share = columns["cost_of_transport"] / baseline_cost(columns["speed_m_per_s"])
        off = np.abs(columns["speed_m_per_s"] / (ADVANCE * columns["omega"]) - 1.0)
        runs[f"{run:g}" if isinstance(run, float) else str(run)] = {
            **columns,
            "share": share,
            "off": off,
        }
    return runs


def preserved(rows: Rows, disturbed: Rows, cell: str) -> dict[str, np.ndarray]:
    """Return the share of CoT⁻¹ that each run keeps under each condition, at its worst command;
    [runs].

    A release that falls keeps nothing.
    """
    undisturbed = per_run(rows, cell)
    worst: dict[str, np.ndarray] = {}
    for name in CONDITIONS:
        disturbed_runs = per_run(
            {title: column[disturbed["condition"] == name] for title, column in disturbed.items()},
            cell,
        )
        with np.errstate(divide="ignore", invalid="ignore"):  # a body that stands has no cost
            shares = [
                disturbed_runs[run]["upright"]
                * columns["cost_of_transport"]
                / disturbed_runs[run]["cost_of_transport"]
                for run, columns in undisturbed.items()
            ]
        worst[name] = np.nan_to_num(np.array(shares)).min(axis=1)
    return worst


def by_family(table: Rows, disturbed: Rows) -> str:
    """Return one row per family: means of the runs over all commands, and the selected run at its
    worst.

    The cost of transport is of the runs that walk: it has no bound where a body stands.
    """
    rows = []
    for cell in RANGE:
        runs = per_run(table, cell.name)
        if not runs:
            continue
        walking = {name: run for name, run in runs.items() if np.all(run["off"] < STANDS)}
        mean = np.array([np.mean(run["share"]) for run in walking.values()])
        worst = np.array([np.max(run["share"]) for run in walking.values()])
        off = np.array([np.mean(run["off"]) for run in runs.values()])
        locked = np.array([np.mean(run["locked"]) for run in runs.values()])
        up = np.array([np.mean(run["upright"]) for run in runs.values()])
        selection = selected(cell.name)
        best = runs[selection]
        rows.append(
            (
                f"`{cell.name.partition('@')[0]}`",
                str(cell.experiment.controller.n_weights),
                f"{sure(up, 2, SHARE)}; {len(walking)} of {len(runs)}",
                sure(locked, 2, SHARE),
                sure(off, 2, POSITIVE),
                sure(mean, 2, POSITIVE),
                sure(worst, 2, POSITIVE),
                f"{selection}: {best['share'].mean():.2f}, {best['share'].max():.2f}, "
                f"{best['locked'].min():.2f}",
            )
        )
    titles = ("family", "numbers", "upright; runs that walk", "locked", "speed off by")
    further = ("of the front", "at worst", "selected run: mean, worst, locked")
    return markdown((*titles, *further), rows)


def by_command(table: Rows, cell: str) -> str:
    """Return the selected run of a cell at every command, with the range of all runs beside it."""
    runs = per_run(table, cell)
    columns = runs[selected(cell)]
    everyone = np.array([run["share"] for run in runs.values()])
    rows = [
        (
            f"{columns['omega'][index]:g}",
            f"{ADVANCE * columns['omega'][index]:.3f}",
            f"{columns['speed_m_per_s'][index]:.3f}",
            f"{columns['cost_of_transport'][index]:.3f}",
            f"{columns['share'][index]:.2f}",
            sure(everyone[:, index], 2, POSITIVE),
            f"{columns['locked'][index]:.2f}, in {columns['lock_time_s'][index]:.0f}",
            str(columns["gait"][index]),
        )
        for index in range(len(columns["omega"]))
    ]
    titles = ("ω", "wanted speed", "speed", "CoT", "of the front", "all runs", "locked")
    return markdown((*titles, "gait"), rows)


def robust(table: Rows, disturbed: Rows) -> str:
    """Return the share of CoT⁻¹ that disturbances leave at the worst command: of all runs, and of
    the selected one."""
    rows = []
    for cell in RANGE:
        if not (table["cell"] == cell.name).any():
            continue
        labels = list(per_run(table, cell.name))
        selection = labels.index(selected(cell.name))
        cells = [
            f"{sure(shares, 2, POSITIVE)}; {shares[selection]:.2f}"
            for shares in preserved(table, disturbed, cell.name).values()
        ]
        rows.append((f"`{cell.name.partition('@')[0]}`", *cells))
    return markdown(("family", *CONDITIONS), rows)


def cells_on(judged: Rows, ending: str) -> list[Cell]:
    """Return the cells of a body that are in a table, in the plan's order."""
    present = set(judged["cell"])
    return [cell for cell in CELLS if cell.name in present and cell.name.endswith(ending)]


def summary(judged: Rows, curves: Rows, ending: str) -> str:
    """Return one row per family of one frequency: fitness, and the gait from random phases."""
    rows = []
    for cell in cells_on(judged, ending):
        mine = judged["cell"] == cell.name
        rows.append(
            (
                f"`{cell.name.partition('@')[0]}`, {cell.experiment.controller.n_weights}",
                sure(final(curves, cell.name)),
                sure(judged["upright"][mine], within=SHARE),
                sure(judged["locked"][mine], within=SHARE),
                sure(judged["lock_time_s"][mine], 0, POSITIVE),
                *(
                    (
                        sure(judged["speed_m_per_s"][mine], 3),
                        sure(judged["cost_of_transport"][mine], 2, POSITIVE),
                    )
                    if "plate" not in ending
                    else ()
                ),
                gaits(judged["gait"][mine]),
            )
        )
    walk = () if "plate" in ending else ("speed", "CoT")
    titles = ("family, numbers", "fitness", "upright", "locked", "locks in", *walk, "gait")
    return markdown(titles, rows)


def final(curves: Rows, name: str) -> np.ndarray:
    """Return the best fitness of each run at the end."""
    return np.array([fitness[-1] for _, fitness in of_runs(curves, name)])


def of_runs(curves: Rows, name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the generations and best fitness so far of every run of a cell."""
    values = []
    for seed in np.unique(curves["seed"][curves["cell"] == name]):
        mine = (curves["cell"] == name) & (curves["seed"] == seed)
        values.append((curves["generation"][mine], curves["best_fitness"][mine]))
    return values


def gaits(names: np.ndarray) -> str:
    """Return the gaits of the runs, the most common first."""
    return ", ".join(f"{name} {count}" for name, count in Counter(names.tolist()).most_common())


def convergence(curves: Rows) -> str:
    """Return the best fitness after a half, two thirds and all of the training of each run."""
    rows = []
    for cell in CELLS:
        runs = of_runs(curves, cell.name)
        if not runs or cell.experiment.is_searched:
            continue
        shares = [
            np.array([np.interp(share * g[-1], g, fitness) for g, fitness in runs])
            for share in (0.5, 2.0 / 3.0, 1.0)
        ]
        lengths = [int(g[-1]) for g, _ in runs]
        length = f"{min(lengths)} to {max(lengths)}" if len(set(lengths)) > 1 else f"{lengths[0]}"
        rows.append((f"`{cell.name}`", length, *map(sure, shares)))
    return markdown(("cell", "generations", "half", "two thirds", "all"), rows)
