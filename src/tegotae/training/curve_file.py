"""`curves.csv`: the learning curves of a training, one format whatever learns.

Columns, a row a point of a seed's curve:

- `seed`: the run's;
- `step`: where in training: generations of a population, episodes of an agent;
- `simulated_s`: simulated time that was learned from until there [s]; evaluations do not count;
- `fitness`, `cot_inverse`: of the distribution's mean, or of the deterministic policy;
- `mean_fitness`, `best_fitness`, `failed_share`: of the generation's samples; empty for agents.

A number that is not measured is an empty cell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import numbers, parse_csv, write_csv


class CurvePoint(NamedTuple):
    """A point of a learning curve; its fields are the columns of `curves.csv`."""

    seed: int
    step: float
    simulated_s: float
    fitness: float
    cot_inverse: float
    mean_fitness: float = math.nan
    best_fitness: float = math.nan
    failed_share: float = math.nan


COLUMNS = CurvePoint._fields
"""The columns of `curves.csv`."""

_OF_GENERATIONS = {
    "generation": "step",
    "centre_fitness": "fitness",
    "centre_cot_inverse": "cot_inverse",
}
"""The columns of earlier versions, of populations."""
_OF_EPISODES = {"episode": "step"}
"""The same, of agents."""


def write_curves(path: Path, points: Sequence[CurvePoint]) -> None:
    """Write the points of all seeds, each seed's together.

    Args:
        path: the file.
        points: of all seeds, in any order.
    """
    rows = sorted(points, key=lambda point: (point.seed, point.step))
    columns = {name: [getattr(row, name) for row in rows] for name in COLUMNS}
    write_csv(path, columns, digits=6)


def is_earlier_format(path: Path) -> bool:
    """Whether the file is of an earlier version of tegotae."""
    try:
        first = path.read_text(encoding="utf-8").partition("\n")[0].split(",")
    except (OSError, ValueError):
        return False
    return "step" not in first


def curves_of(path: Path, per_generation_s: float = math.nan) -> Mapping[str, np.ndarray]:
    """The columns `COLUMNS` of a `curves.csv`, also of earlier versions, shape [points] each.

    Args:
        path: the file.
        per_generation_s: simulated time of a generation [s], which populations of earlier versions
            did not write.

    Raises:
        TegotaeError: for a file that cannot be read or is no such table.
    """
    try:
        cells = parse_csv(path.read_text(encoding="utf-8"))
        earlier = _OF_GENERATIONS if "generation" in cells else _OF_EPISODES
        found = {earlier.get(name, name): numbers(map(str, each)) for name, each in cells.items()}
        n = len(found["seed"])
        if "simulated_s" not in found:
            found["simulated_s"] = found["step"] * per_generation_s
        for needed in ("step", "cot_inverse"):
            if len(found[needed]) != n:
                raise ValueError("rows of unequal length")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, KeyError) as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    return {name: found.get(name, np.full(n, np.nan)) for name in COLUMNS}
