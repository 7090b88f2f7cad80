"""The learned laws of the study as a file of the zoo, with what the evaluation says of each run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from research.learned_legs.evaluate import OMEGAS
from research.learned_legs.plan import TABLES, ZOO, Cell, baseline_cost
from research.reproduction.zoo import ZooEntry, write_archive
from tegotae._support.documents import JsonObject
from tegotae._support.files import output_folder
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
    selection, test = (
        pd.read_csv(TABLES / f"{name}.csv", dtype={"run": str}, index_col="cell").loc[[cell.name]]
        for name in ("selection", "range")
    )
    test = test.assign(
        cot_inverse=1.0 / test.cost_of_transport,
        of_front=test.cost_of_transport / baseline_cost(test.speed_m_per_s.to_numpy()),
    )
    means = test.groupby("run")[["cot_inverse", "of_front", "locked", "upright"]].mean()
    table = means.assign(selection=selection.set_index("run").score).loc[seeds]
    names = ("selection", "cot_inverse", "of_front", "locked", "upright")
    return {name: table[name].to_numpy() for name in names}
