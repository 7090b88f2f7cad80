"""Judging the study's controllers: from random phases, at the frequency trained at and others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from kept import write_rows
from learned_legs_plan import TABLES, Cell
from learned_legs_vanilla import forced
from tegotae._support.files import output_folder, write_atomically
from tegotae._support.progress import reporting
from tegotae._support.tables import read_csv
from tegotae.parts.bodies import Walker
from tegotae.studies.gaits.evaluation import GaitEvaluation, evaluate_gaits
from tegotae.systems.controller_file import load
from tegotae.systems.controller_set import ControllerSet
from tegotae.systems.legged import Legged
from tegotae.systems.legged_systems import settling
from tegotae.training.collection import read

OMEGAS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)
"""Frequencies that a walker is evaluated at [rad/s]."""
STARTS = 8
"""Random releases at each."""
GAITS = 32
"""Random releases at the frequency trained at."""
FORCED = (1.0, 2.0, 3.0)
"""Frequencies at which gaits are forced on legs without feedback [rad/s]."""


def runs_of(cell: Cell, folder: Path) -> tuple[ControllerSet, Legged]:
    """The controllers of a cell, and the system that they drive."""
    (runs,) = read(folder / cell.name)
    return runs, settling(runs.system, runs.weights[0])


def rows_of(cell: Cell, runs: ControllerSet, found: GaitEvaluation) -> list[dict[str, Any]]:
    """A row per controller and frequency."""
    measures = found.measures
    rows = []
    for run, label in enumerate(runs.labels):
        for at, omega in enumerate(found.omega):
            gait, share = found.commonest(run, at)
            own = {"cell": cell.name, "run": label, "omega_t": cell.design.frequency}
            own |= {"omega": omega, **{name: x[run, at] for name, x in measures.items()}}
            rows.append(own | {"gait": gait, "gait_share": share})
    return rows


def evaluate_all(cells: list[Cell], folder: Path) -> None:
    """Write all tables that need no disturbance; what has been evaluated before is kept.

    `judged.csv`: every controller at the frequency trained at; `gaits.csv`: the same by gait;
    `range.csv`: at other frequencies; `forced.csv`: gaits by themselves; `curves.csv`: training.
    """
    found: dict[str, list[dict[str, Any]]] = {"judged": [], "gaits": [], "range": []}
    with reporting("evaluate", len(cells)) as reporter:
        for done, cell in enumerate(cells, 1):
            for name, rows in evaluated_cell(cell, folder).items():
                found[name] += rows
            reporter.update(done, cell.name)
    for name, rows in found.items():
        write_rows(TABLES / f"{name}.csv", rows, digits=4, by=("cell",))
    write_rows(TABLES / "curves.csv", curves_of(cells, folder), digits=4, by=("cell",))
    write_rows(TABLES / "forced.csv", forced(FORCED), digits=4)


def evaluated_cell(cell: Cell, folder: Path) -> dict[str, list[dict[str, Any]]]:
    """The rows of a cell, from its folder if they are there."""
    kept = folder / "judged" / f"{cell.name}.json"
    if kept.exists():
        return json.loads(kept.read_text())
    runs, legged = runs_of(cell, folder)
    own = evaluate_gaits(legged, runs.weights, starts=GAITS)
    found = {"judged": rows_of(cell, runs, own), "gaits": gaits_of(cell, runs, own), "range": []}
    walks = legged.omega is not None and isinstance(legged.body, Walker)
    if walks and cell.design.omega is None:
        found["range"] = rows_of(cell, runs, evaluate_gaits(legged, runs.weights, OMEGAS, STARTS))
    output_folder(kept.parent)
    write_atomically(kept, json.dumps(found, default=float))
    return found


def gaits_of(cell: Cell, runs: ControllerSet, found: GaitEvaluation) -> list[dict[str, Any]]:
    """A row per controller and gait: how many starts, how fast, at what cost."""
    rows = []
    for run, label in enumerate(runs.labels):
        for gait in np.unique(found.gait[run, 0]):
            own = found.gait[run, 0] == gait
            speed, cost = (
                np.asarray(x)[run, 0][own]
                for x in (found.found.speed_m_per_s, found.found.cost_of_transport)
            )
            row = {"cell": cell.name, "run": label, "gait": gait, "starts": int(own.sum())}
            rows.append(row | {"speed_m_per_s": speed.mean(), "cost_of_transport": cost.mean()})
    return rows


def curves_of(cells: list[Cell], folder: Path) -> list[dict[str, Any]]:
    """The best fitness so far of every run, every tenth generation."""
    rows = []
    for cell in cells:
        if cell.experiment.is_searched:
            (file,) = (folder / cell.name).glob("*-seed*.json")
            best = load(file).training["best_fitness"]
            rows.append({"cell": cell.name, "seed": 0, "generation": 0, "best_fitness": best})
            continue
        table = read_csv(folder / cell.name / "curves.csv")
        seeds, fitness = (np.array(table[n], float) for n in ("seed", "fitness"))
        for seed in range(cell.seeds):
            best = np.maximum.accumulate(fitness[seeds == seed])
            for at in range(9, len(best), 10):
                own = {"cell": cell.name, "seed": seed, "generation": at + 1}
                rows.append(own | {"best_fitness": best[at]})
    return rows
