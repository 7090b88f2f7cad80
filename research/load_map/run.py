"""Tune every law in every cell of the map, and judge it from other starts.

    python -m research.load_map.run tune     # what is missing; half an hour of a core
    python -m research.load_map.run report   # table, figure and statistic of the page

Searches are kept in `runs/load_map`; rows of judged controllers are in `research/load_map`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from research.frame import Table, main
from research.legs_limit import strategies
from research.load_map import laws
from research.load_map.cells import CELLS, Cell
from research.load_map.report import GENERATIONS, ROWS, report
from tegotae._support.files import output_folder

FOLDER = Path("runs/load_map")
SEEDS, POPULATION, STARTS, STD = 10, 12, 2, 0.5
"""Searches of a law in a cell, candidates of a generation, training starts of each, and the first
deviation of a candidate in units of a number's range."""
DOUBLED = 80
"""Twice the budget, for some cells; half of the budget is judged in all."""
DOUBLE = ("quadruped, reference", "quadruped, reference, any phases")
"""Cells whose searches of load and clock go on to the double of the budget."""
JUDGED = 20
"""Starts from which a tuned law is judged; their seeds are below those of the training."""
UNSEEN = 1_000_000


def laws_of(cell: Cell) -> tuple[str, ...]:
    """Return the laws that are compared in a cell."""
    if cell.mechanics.limbs == 1:
        return "neither", "load"
    return tuple(laws.LAWS)[: 5 if cell.loses_phase and cell.walks else 4]


def tune(only: str = "", dir: Path = FOLDER, generations: int = GENERATIONS) -> None:
    """Tune and judge what is missing.

    Args:
        only: beginning of the names of the cells that are looked at; all by default.
        dir: folder of the searches.
        generations: the budget.
    """
    output_folder(dir)
    cells_by_name = {cell.name: cell for cell in CELLS if cell.name.startswith(only)}
    cells = [
        (name, law, generations) for name, cell in cells_by_name.items() for law in laws_of(cell)
    ]
    doubled = [
        (name, law, DOUBLED)
        for name in DOUBLE
        if name in cells_by_name
        for law in ("load", "clock")
    ]
    table = Table(ROWS, ("cell", "law", "generations"), digits=4)
    table.measure(
        cells + doubled, lambda name, law, budget: rows(cells_by_name[name], law, budget, dir)
    )


def rows(cell: Cell, law: str, generations: int, folder: Path) -> list[dict[str, object]]:
    """Return a row for each search: means of its controller from the judged starts."""
    size = len(laws.ranges(cell, law))
    start = np.array([np.random.default_rng(seed).normal(size=12) for seed in range(SEEDS)])
    file = folder / f"{cell.name}, {law}.npz"
    half = folder / f"{cell.name}, {law}, half.npy"

    def losses(x: np.ndarray, generation: int) -> np.ndarray:
        seed = np.arange(SEEDS)[:, None, None] * 1000 + generation
        seed = UNSEEN + STARTS * seed + np.arange(STARTS)
        seeds = np.broadcast_to(seed, (SEEDS, POPULATION, STARTS)).ravel()
        results = laws.episodes(cell, law, np.repeat(x, STARTS, axis=0), seeds)
        return -results["fitness"].reshape(-1, STARTS).mean(axis=1)

    def searched(until: int) -> np.ndarray:
        return strategies.search(
            losses, STD * start[:, :size], std=STD, population=POPULATION, generations=until,
            seed=0, checkpoint=file,
        ).centre  # fmt: skip

    if not half.exists():
        np.save(half, searched(GENERATIONS // 2))
    budgets = {generations: searched(generations)}
    if generations == GENERATIONS:
        budgets[GENERATIONS // 2] = np.load(half)
    return [row for budget, x in budgets.items() for row in judged(cell, law, budget, x)]


def judged(cell: Cell, law: str, budget: int, x: np.ndarray) -> list[dict[str, object]]:
    """Return means over starts, of search k, and the mean merit over searches, from start k."""
    lanes, seeds = np.repeat(x, JUDGED, axis=0), np.tile(np.arange(JUDGED), SEEDS)
    measured = laws.episodes(cell, law, lanes, seeds)
    measured["lock"] = np.full(len(lanes), np.nan)
    if cell.mechanics.limbs > 1:
        measured["lock"] = laws.locks(cell, law, lanes, seeds)
    measured = {name: value.reshape(SEEDS, JUDGED) for name, value in measured.items()}
    up, locked = ~measured["fell"], np.isfinite(measured["lock"])
    rows: list[dict[str, object]] = []
    for k in range(JUDGED):
        row: dict[str, object] = {"cell": cell.name, "law": law, "generations": budget, "k": k}
        row["start_merit"] = measured["merit"][:, k].mean()
        if k < SEEDS:
            row |= {"merit": measured["merit"][k].mean(), "fell": measured["fell"][k].mean(),
                    "speed": mean_of(measured["speed"][k], up[k]),
                    "cost": mean_of(measured["cost"][k], up[k]), "locked": locked[k].mean(),
                    "lock": mean_of(measured["lock"][k], locked[k])}  # fmt: skip
            row["x"] = " ".join(f"{number:.3f}" for number in x[k])
        rows.append(row)
    return rows


def mean_of(values: np.ndarray, mask: np.ndarray) -> float:
    """Return the mean of some values, NaN of none."""
    return float(values[mask].mean()) if mask.any() else float("nan")


if __name__ == "__main__":
    main(tune, report)
