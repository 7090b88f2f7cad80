"""The learned laws of the study as a file of the zoo, with what the evaluation says of each run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from research.learned_legs.evaluate import OMEGAS
from research.learned_legs.plan import TABLES, ZOO, Cell, baseline_cost
from research.reproduction.zoo import ZooEntry, write_archive
from tegotae._support.documents import JsonObject
from tegotae._support.files import output_folder
from tegotae._support.tables import read_csv
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController, load

STUDY = "legs"
"""Name of the study in names of the zoo."""
_OF_A_RUN = ("seed", "best_fitness", "best_generation", "generations", "ended", "episodes")
_OF_THE_STUDY = ("seeds", "simulated_s")


def write_zoo(cells: list[Cell], folder: Path) -> None:
    """Write all runs of these cells to the package's file of the study."""
    output_folder(ZOO.parent)
    write_archive(ZOO, STUDY, [entry(cell, folder) for cell in cells])


def entry(cell: Cell, folder: Path) -> ZooEntry:
    """Return the runs of a cell, and its evaluation: means over the commands."""
    controllers = [load(file) for file in (folder / cell.name).glob("*-seed*.json")]
    runs = sorted(controllers, key=lambda run: int(str(run.training["seed"])))
    return ZooEntry(
        document=document(runs[0], cell.name),
        weights=np.stack([run.weights for run in runs]),
        **{
            n: np.array([run.training[n] for run in runs]) for n in ("seed", "generations", "ended")
        },
        fitness=np.array([run.training["best_fitness"] for run in runs]),
        metrics=measured(cell, [str(run.training["seed"]) for run in runs]),
    )


def document(saved: SavedController, cell: str) -> JsonObject:
    """Return the entries that the controller files of all runs share."""
    leave = {*_OF_A_RUN, *_OF_THE_STUDY}
    training = {name: x for name, x in saved.training.items() if name not in leave}
    common = SavedController(
        saved.system,
        saved.weights,
        saved.name,
        saved.experiment,
        training={**training, "omega": [min(OMEGAS), max(OMEGAS)]},
        software=saved.software,
    )
    result = controller_file.described(common, cell)
    return {name: value for name, value in result.items() if name != "weights"}


def measured(cell: Cell, seeds: list[str]) -> dict[str, np.ndarray]:
    """Return the score of the selection, and the test's means over the commands, [runs] each."""
    selection, test = (read_csv(TABLES / f"{name}.csv") for name in ("selection", "range"))
    metrics: dict[str, list[float]] = {
        name: [] for name in ("selection", "cot_inverse", "of_front")
    }
    metrics |= {name: [] for name in ("locked", "upright")}
    for seed in seeds:
        mask = of_run(selection, cell.name, seed)
        metrics["selection"].append(float(np.array(selection["score"], float)[mask][0]))
        mask = of_run(test, cell.name, seed)
        columns = ("speed_m_per_s", "cost_of_transport", "locked", "upright")
        speed, cost, locked, up = (np.array(test[name], float)[mask] for name in columns)
        metrics["cot_inverse"].append(float(np.mean(1.0 / cost)))
        metrics["of_front"].append(float(np.mean(cost / baseline_cost(speed))))
        metrics["locked"].append(float(locked.mean()))
        metrics["upright"].append(float(up.mean()))
    return {name: np.array(values) for name, values in metrics.items()}


def of_run(table: Mapping[str, np.ndarray], cell: str, run: str) -> np.ndarray:
    """Return True for the rows of a run in a table."""
    pairs = zip(table["cell"], table["run"], strict=True)
    return np.array([(str(c), str(r)) == (cell, run) for c, r in pairs])
