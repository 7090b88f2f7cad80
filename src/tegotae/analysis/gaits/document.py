"""What a gait command writes beside its pictures: a table (.csv), and all of it (.json).

Both have the same rows: a row of the table is an object of the document, an empty cell a null.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.engines import selected
from tegotae._support.files import write_atomically
from tegotae._support.tables import write_csv
from tegotae.measures.gaits.summary import Coordination
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged

_OF_LEGS = ("lag", "lag_spread", "touchdown_lag", "step_frequency_hz", "duty_factor")
_UNITS = {name: f"{name}_cycles" for name in ("lag", "lag_spread", "touchdown_lag", "moved")}

DIGITS = 9
"""Significant digits of what is written: more than single precision has."""


def coordination_columns(found: Coordination, legs: Sequence[str]) -> dict[str, np.ndarray]:
    """The coordination of lanes as columns, what belongs to a leg with its name at the end.

    Args:
        found: arrays [limbs, lanes] and [lanes].
        legs: the legs' names.

    Example:
        >>> values = {name: np.zeros(3) for name in Coordination._fields}
        >>> values |= {name: np.zeros((2, 3)) for name in _OF_LEGS}
        >>> list(coordination_columns(Coordination(**values), ("H", "F")))[:3]
        ['lag_cycles_H', 'lag_cycles_F', 'lag_spread_cycles_H']
    """
    columns = {}
    for name, values in found._asdict().items():
        title = _UNITS.get(name, name)
        if name in _OF_LEGS:
            columns |= {f"{title}_{leg}": values[i] for i, leg in enumerate(legs)}
        else:
            columns[title] = values
    return {name: np.asarray(values) for name, values in columns.items()}


def system_document(legged: Legged) -> JsonObject:
    """A system as JSON values.

    Raises:
        TegotaeError: for a part that is not registered (`tegotae.register`).
    """
    return {**describe(legged), "legs": list(legged.names)}


def write(
    folder: Path, name: str, document: Mapping[str, object], rows: Mapping[str, ArrayLike]
) -> list[Path]:
    """Write `NAME.csv` and `NAME.json`, whole or not at all.

    Args:
        folder: where to.
        name: of both files.
        document: what stands before the rows in the document.
        rows: columns of one length, by name.

    Raises:
        TegotaeError: if they cannot be written.
    """
    table = {title: _rounded(column) for title, column in rows.items()}
    csv, whole = folder / f"{name}.csv", folder / f"{name}.json"
    write_csv(csv, table, digits=DIGITS)
    values = {**document, "engine": selected(), "rows": _objects(table)}
    write_atomically(whole, json.dumps(as_json(values), indent=1, allow_nan=False) + "\n")
    return [csv, whole]


def _objects(table: Mapping[str, np.ndarray]) -> list[JsonObject]:
    columns = [column.tolist() for column in table.values()]
    return [dict(zip(table, row, strict=True)) for row in zip(*columns, strict=True)]


def _rounded(column: ArrayLike) -> np.ndarray:
    """Numbers with as many digits as are written, so that both files have the same ones."""
    values = np.asarray(column)
    if values.dtype.kind != "f":
        return values
    return np.array([float(f"{x:.{DIGITS}g}") for x in values.astype(float)])
