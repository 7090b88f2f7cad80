"""The numbers behind a figure, written beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.tables import write_csv
from tegotae.parts._shapes import AnyArray

_DIGITS = 9

Table = Mapping[str, ArrayLike]
"""Columns by name; each an array of one shape, or a single value for all rows."""


def long_table(
    rows: tuple[str, np.ndarray], columns: tuple[str, np.ndarray], maps: Mapping[str, AnyArray]
) -> dict[str, np.ndarray]:
    """Maps over two axes as a table with one row per cell.

    Args:
        rows: name and values of the first axis.
        columns: name and values of the second.
        maps: arrays of shape [rows, columns].
    """
    row, column = np.meshgrid(rows[1], columns[1], indexing="ij")
    cells = {rows[0]: row, columns[0]: column, **maps}
    return {name: np.asarray(cell).ravel() for name, cell in cells.items()}


def joined(tables: Mapping[str, Table], by: str) -> dict[str, np.ndarray]:
    """Tables of the same columns below each other, with their names as the first column."""
    whole = {name: _broadcast(table) for name, table in tables.items()}
    lengths = [len(next(iter(table.values()))) for table in whole.values()]
    names = next(iter(whole.values()))
    return {
        by: np.repeat(list(whole), lengths),
        **{name: np.concatenate([table[name] for table in whole.values()]) for name in names},
    }


def write_tables(figure: Path, tables: Mapping[str, Table]) -> list[Path]:
    """Write tables as CSV beside a figure; undefined values are left empty.

    Args:
        figure: the figure's path, such as `map.png`.
        tables: by name; the one named "" becomes `map.csv`, others `map.NAME.csv`.

    Raises:
        TegotaeError: if a file cannot be written.
    """
    written = []
    for name, table in tables.items():
        path = figure.with_suffix(f".{name}.csv" if name else ".csv")
        write_csv(path, _broadcast(table), digits=_DIGITS)
        written.append(path)
    return written


def _broadcast(table: Table) -> dict[str, np.ndarray]:
    columns = np.broadcast_arrays(*(np.atleast_1d(column) for column in table.values()))
    return dict(zip(table, columns, strict=True))
