"""The study's table as files, and two folders made one."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from tegotae.errors import TegotaeError
from tegotae.extras import require
from tegotae.files import output_file, output_folder, write_atomically
from tegotae.study.folder import Folder
from tegotae.study.record import SUFFIX, DamagedRecordError, read
from tegotae.study.table import Table


def write_csv(table: Table, path: Path) -> None:
    """Write the table as CSV; undefined numbers are empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(table.columns)
    for row in zip(*table.columns.values(), strict=True):
        writer.writerow([_cell(value) for value in row])
    write_atomically(output_file(path), stream.getvalue())


def _cell(value) -> str:
    if isinstance(value, np.floating | float):
        return "" if np.isnan(value) else f"{value:.6g}"
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


def merge(source: Folder, target: Folder) -> int:
    """Copy the records of one folder that another lacks; return how many.

    Raises:
        TegotaeError: if the folders hold different studies, or the target is in use.
    """
    if source.document != target.document:
        raise TegotaeError(
            f"{source.path} and {target.path} hold different studies; they cannot be merged"
        )
    output_folder(target.records)
    copied = 0
    with target.locked():
        for path in sorted(source.records.glob(f"*{SUFFIX}")):
            place = target.records / path.name
            if place.exists():
                continue
            try:
                read(path)
            except DamagedRecordError as error:
                print(f"{error}; it is left out")
                continue
            write_atomically(place, path.read_bytes())
            copied += 1
    return copied
