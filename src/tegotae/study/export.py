"""The study's table as files, and two folders made one."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import jax
import numpy as np

from tegotae.errors import TegotaeError
from tegotae.evaluation import LATER_METRICS, METRICS
from tegotae.extras import require
from tegotae.files import output_file, output_folder, write_atomically
from tegotae.study.folder import Folder
from tegotae.study.plan import united
from tegotae.study.record import SUFFIX, Record, write
from tegotae.study.table import Table
from tegotae.study.unit import key_of

_WORDS = (
    "model",
    "architecture",
    "learned",
    "reaction",
    "gain",
    "actuation",
    "observation",
    "ended",
)
"""Columns of the table that are no numbers."""


def write_csv(table: Table, path: Path) -> None:
    """Write the table as CSV; undefined numbers are empty."""
    write_atomically(output_file(path), csv_of(table))


def csv_of(table: Table) -> str:
    """The table as the text of a CSV file; undefined numbers are empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(table.columns)
    for row in zip(*table.columns.values(), strict=True):
        writer.writerow([_cell(value) for value in row])
    return stream.getvalue()


def _cell(value) -> str:
    if isinstance(value, np.floating | float):
        return "" if np.isnan(value) else repr(float(value))
    return str(value)


def write_parquet(table: Table, path: Path) -> None:
    """Write the table as Parquet (extra "study").

    Raises:
        TegotaeError: if pyarrow is not installed or the file cannot be written.
    """
    arrow = require("pyarrow", "study")
    parquet = require("pyarrow.parquet", "study")
    columns = {name: list(column.tolist()) for name, column in table.columns.items()}
    stream = io.BytesIO()
    parquet.write_table(arrow.table(columns), stream)
    write_atomically(output_file(path), stream.getvalue())


def read_csv(path: Path) -> Table:
    """The table that `write_csv` wrote.

    Raises:
        TegotaeError: if the file cannot be read or is no such table.
    """
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream))
        names, *cells = rows
        asked = {*_WORDS, "run", "omega_t", "best_fitness", *METRICS} - LATER_METRICS - {"ended"}
        if not asked <= set(names) or not cells:
            raise ValueError("columns are missing")
        columns = dict(zip(names, zip(*cells, strict=True), strict=True))
        columns = {name: ("",) * len(cells) for name in METRICS if name not in columns} | columns
        return Table({name: _column(name, list(values)) for name, values in columns.items()})
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError:
        raise TegotaeError(f"{path} is no table that tegotae study export wrote") from None


def _column(name: str, cells: list[str]) -> np.ndarray:
    if name in _WORDS:
        return np.array(cells)
    if name == "run":
        return np.array(cells, int)
    return np.array([cell or "nan" for cell in cells], float)


def merge(source: Folder, target: Folder) -> int:
    """Copy the records of one folder that another lacks; return how many.

    Of records that both have and that differ, though their settings are equal, it says so.

    Raises:
        TegotaeError: if the folders hold different studies, or the target is in use or cannot be
            written.
    """
    try:
        united(target.document, source.document)
    except TegotaeError as error:
        raise TegotaeError(
            f"{source.path} and {target.path} hold different studies, with {error}; they cannot "
            "be merged"
        ) from None
    output_folder(target.records)
    with target.locked():
        target.describe(source.document)
        whole, others = source.all()
        for message in others:
            print(f"{source.path}: {message}")
        there = {key_of(record.configuration): record for record in target.all()[0]}
        for record in whole:
            other = there.get(key_of(record.configuration), record)
            if _content(other) != _content(record):
                print(
                    f"{record.model} differs in {source.path} and {target.path}, at equal "
                    f"settings: made with {_made_with(record)}, and with {_made_with(other)}"
                )
        lacking = [r for r in whole if key_of(r.configuration) not in there]
        for record in lacking:
            write(record, target.records / f"{key_of(record.configuration)}{SUFFIX}")
    return len(lacking)


def _content(record: Record) -> list[bytes]:
    """All that was found, to be compared bit for bit."""
    found = {name: value for name, value in vars(record).items() if name != "software"}
    return [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(found)]


def _made_with(record: Record) -> str:
    return ", ".join(f"{name} {version}" for name, version in record.software.items())
