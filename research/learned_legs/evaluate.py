"""Judging the study's controllers by releases that no training met, and choosing among runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from research.frame import write_rows
from research.learned_legs.plan import TABLES, Cell, advance_m_per_rad, baseline_cost
from tegotae._support.progress import reporting
from tegotae.analysis.gaits.releases import Releases, release_all
from tegotae.measures.objectives.walking import TRACKING, log_gain
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.fields import replace
from tegotae.systems.controller_file import ControllerSet, load
from tegotae.systems.legged import Legged, settling
from tegotae.systems.vanilla import legged_named
from tegotae.training.collection import read_runs

OMEGAS = tuple(float(x) for x in np.arange(1.0, 3.51, 0.25))
"""Commands that a law for a range is evaluated at [rad/s]."""
SELECTION_SEED, TEST_SEED = 101, 202
"""Seeds of the releases for the selection of runs, and of those for the test."""
SELECTION, TEST, GAITS, DISTURBED = 8, 16, 32, 4
"""Random releases: of the selection, of the test, of cells of one frequency, and disturbed; at
each command."""
USUAL: Mapping[str, LaneNumbers] = {"mass_kg": 1.0, "noise": 0.0, "delay_s": 0.0}
"""Undisturbed. Always given, so that all evaluations of a law are one compiled program."""
CONDITIONS: dict[str, Mapping[str, LaneNumbers]] = {
    "mass 0.8": {"mass_kg": 0.8},
    "mass 1.2": {"mass_kg": 1.2},
    "noise 0.05": {"noise": 0.05},
    "delay 0.03": {"delay_s": 0.03},
}
"""Disturbances of laws for a range; noise in units of the weight, delay in √(l0/g)."""
TIMING = legged_named("quadruped-c").timing
"""Timing of every evaluation: that of the fronts."""
FALLEN = -10.0
"""Score of a release that falls in the selection: less than that of any walk."""


def runs_of(cell: Cell, folder: Path) -> tuple[ControllerSet, Legged]:
    """Return the controllers of a cell, and the system that they drive."""
    (runs,) = read_runs(folder / cell.name)
    return runs, settling(runs.system, runs.weights[0])


def rows_of(cell: Cell, runs: ControllerSet, releases: Releases) -> list[dict[str, Any]]:
    """Return one row per controller and frequency."""
    rows = releases.summary
    rows["run"] = np.array(runs.labels)[rows["run"]]
    rows.insert(0, "cell", cell.name)
    return rows.to_dict("records")


def evaluate_all(cells: list[Cell], folder: Path) -> None:
    """Write the tables; those of cells that are left out stay.

    `selection.csv`: every run of a law for a range by its own set of releases; `range.csv`: the
    same runs by others; `disturbed.csv`: once more, disturbed; `judged.csv`: cells of one
    frequency; `curves.csv`: training.
    """
    with reporting("evaluate", len(cells)) as reporter:
        for index, cell in enumerate(cells, 1):
            runs, legged = runs_of(cell, folder)
            for name, rows in (ranged if cell.ranged else judged)(cell, runs, legged).items():
                write_rows(TABLES / f"{name}.csv", rows, digits=4, by=("cell",))
            write_rows(TABLES / "curves.csv", curves_of(cell, folder), digits=4, by=("cell",))
            reporter.update(index, cell.name)


def judged(cell: Cell, runs: ControllerSet, legged: Legged) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of a cell of one frequency."""
    releases = release_all(legged, runs.weights, starts=GAITS, seed=1)
    return {"judged": rows_of(cell, runs, releases)}


def ranged(cell: Cell, runs: ControllerSet, legged: Legged) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of a law for a range: selection, test, and the test under disturbances."""

    def at_all(starts: int, seed: int, changes: Mapping[str, LaneNumbers]) -> Releases:
        meets = {**USUAL, **changes}
        timed = replace(legged, {"timing": TIMING})
        return release_all(timed, runs.weights, OMEGAS, starts, seed=seed, changes=meets)

    chosen_by = at_all(SELECTION, SELECTION_SEED, {})
    selection = [
        {"cell": cell.name, "run": label, "score": score}
        for label, score in zip(
            runs.labels, scores(chosen_by, advance_m_per_rad(cell.design)), strict=True
        )
    ]
    disturbed = [
        {**row, "condition": name}
        for name, changes in CONDITIONS.items()
        for row in rows_of(cell, runs, at_all(DISTURBED, TEST_SEED, changes))
    ]
    test = rows_of(cell, runs, at_all(TEST, TEST_SEED, {}))
    return {"selection": selection, "range": test, "disturbed": disturbed}


def scores(releases: Releases, advance: float) -> np.ndarray:
    """Return the training's fitness on these releases: its mean over the commands, [runs].

    Args:
        releases: what the runs did.
        advance: the way per radian of the command that is wanted [m/rad].
    """
    table: Any = releases.summary
    names = ("speed_m_per_s", "cost_of_transport", "upright", "omega")
    speed, cost, up, omega = (table[name].to_numpy() for name in names)
    gain = np.nan_to_num(baseline_cost(speed) / cost)
    off = np.abs(np.nan_to_num(speed) / (advance * omega) - 1.0)
    walks = np.asarray(log_gain(gain), float) - TRACKING * off
    score = up * walks + (1.0 - up) * FALLEN
    return score.reshape(table["run"].nunique(), -1).mean(axis=-1)


def selected(cell: str) -> str:
    """Return the run of a cell that the selection prefers; no other table is read."""
    table = pd.read_csv(TABLES / "selection.csv", dtype={"run": str})
    table = table[table.cell == cell]
    return table.run[table.score.idxmax()]


def curves_of(cell: Cell, folder: Path) -> list[dict[str, Any]]:
    """Return the best fitness so far of every run, every tenth generation and the last."""
    if cell.experiment.is_searched:
        (file,) = (folder / cell.name).glob("*-seed*.json")
        best = load(file).training["best_fitness"]
        return [{"cell": cell.name, "seed": 0, "generation": 0, "best_fitness": best}]
    table = pd.read_csv(folder / cell.name / "curves.csv")
    rows = []
    for seed, run in table.groupby("seed"):
        best = run.fitness.cummax().to_numpy()
        for index in sorted({*range(9, len(best), 10), len(best) - 1}):
            labels = {"cell": cell.name, "seed": seed, "generation": index + 1}
            rows.append(labels | {"best_fitness": best[index]})
    return rows
