"""The experiments beside the study: small tables and figures of algorithms, sizes and gains."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.errors import TegotaeError

RIDGES, RESONANCES, LOSSES = (f"gain_map.{name}.csv" for name in ("ridge", "resonance", "loss"))
"""Tables of the gain map: the best gain per frequency, the best frequency per gain, and what is
lost beside each frequency."""

PARAMETERS = 128
"""More than these the paper could not train."""


@dataclass(frozen=True)
class Training:
    """A training of some number of parameters: fitness of its first distribution, and its best."""

    method: str
    parameters: int
    untrained_fitness: float
    fitness: float


def read_trainings(path: Path) -> list[Training]:
    """Read the trainings of a table such as `parameter_limit.csv`.

    Raises:
        TegotaeError: if it cannot be read.
    """
    columns = ("way", "parameters", "untrained_fitness", "fitness")
    return [Training(*row) for row in _rows(path, columns, (str, int, float, float))]


def read_ridges(folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Read frequencies and the best gain at each, by actuation; NaN where that is at the map's
    edge.

    Raises:
        TegotaeError: if the table cannot be read.
    """
    columns = ("omega_rad_per_s", "best_sigma_rad_per_s_n", "censored")
    columns_by_name = _by_actuation(folder / RIDGES, columns)
    return {
        name: (omega, np.where(censored == 0.0, sigma, np.nan))
        for name, (omega, sigma, censored) in columns_by_name.items()
    }


def read_resonances(folder: Path) -> dict[str, np.ndarray]:
    """Read the best frequency of each gain that has one, by actuation.

    Raises:
        TegotaeError: if the table cannot be read.
    """
    resonances = _by_actuation(folder / RESONANCES, ("best_omega_rad_per_s",))
    return {name: omega for name, (omega,) in resonances.items()}


def read_losses(folder: Path) -> dict[str, np.ndarray]:
    """Read the share of CoT⁻¹ that is lost 1 rad/s beside each frequency, by actuation.

    Raises:
        TegotaeError: if the table cannot be read.
    """
    losses = _by_actuation(folder / LOSSES, ("cot_inverse_a_lost",))
    return {name: share for name, (share,) in losses.items()}


def _by_actuation(path: Path, columns: tuple[str, ...]) -> dict[str, tuple[np.ndarray, ...]]:
    rows = _rows(path, ("actuation", *columns), (str, *(float for _ in columns)))

    def columns_of(actuation: str) -> tuple[np.ndarray, ...]:
        values = np.array([row[1:] for row in rows if row[0] == actuation], float)
        return tuple(values.reshape(-1, len(columns)).T)

    return {name: columns_of(name) for name in ("sector", "reflex")}


def _rows(
    path: Path, columns: Iterable[str], types: Iterable[Callable[[str], object]]
) -> list[tuple]:
    """Return some columns of a table, converted."""
    columns, types = tuple(columns), tuple(types)
    kind = f"table with rows of {', '.join(columns)}"
    cells = tables.read_csv(path, columns, kind=kind)
    try:
        converted = [
            [make(cell) for cell in cells[name].tolist()]
            for name, make in zip(columns, types, strict=True)
        ]
        if any(isinstance(x, float) and not np.isfinite(x) for row in converted for x in row):
            raise ValueError
    except ValueError:
        raise TegotaeError(f"{path} is no {kind}: a cell is no number") from None
    return list(zip(*converted, strict=True))


@dataclass(frozen=True)
class KeptExperiment:
    """An experiment that some claims are about.

    Args:
        tables: the names of its tables.
        figure: the name of its figure.
        caption: what the figure shows.
        command: what measures it, with {folder} for the folder that table and figure go to.
    """

    tables: tuple[str, ...]
    figure: str
    caption: str
    command: str


EXPERIMENTS = (
    KeptExperiment(
        ("figure3.csv", "figure3_gaits.csv"),
        "figure3.png",
        "CoT⁻¹ in the course of training, by algorithm (Fig. 3 of the paper)",
        "python -m research.experiments.figure3 --tables {folder}",
    ),
    KeptExperiment(
        ("parameter_limit.csv",),
        "parameter_limit.png",
        "Fitness over the number of trained parameters",
        "python -m research.experiments.parameter_limit --out {folder}",
    ),
    KeptExperiment(
        (RIDGES, RESONANCES, LOSSES),
        "gain_map.png",
        "CoT⁻¹ over gain and frequency, with the best gain per frequency (Fig. 4 of the paper)",
        "python -m research.reproduction gain-map --out {folder}/gain_map.png",
    ),
)
"""The experiments, by Figs. 3, none and 4 of the paper."""


def command_for(table: str, folder: Path | None = None) -> str:
    """Return the command that measures the content of a table, and leaves it in a folder.

    Example:
        >>> command_for("parameter_limit.csv")
        'python -m research.experiments.parameter_limit --out experiments'
    """
    match = next(experiment for experiment in EXPERIMENTS if table in experiment.tables)
    return match.command.format(folder=folder or "experiments")


def require_folder(folder: Path | None) -> None:
    """Raise `TegotaeError` for a folder of tables that is not there; None is no error."""
    if folder is not None and not folder.is_dir():
        raise TegotaeError(f"there is no folder {folder}")
