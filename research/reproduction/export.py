"""The study's table as files, and two folders made one."""

from __future__ import annotations

from pathlib import Path

import jax
import numpy as np

from research.reproduction.cells import require_once, whole_number
from research.reproduction.folder import Folder
from research.reproduction.plan import united
from research.reproduction.record import Record
from research.reproduction.table import StudyTable
from research.reproduction.unit import record_key
from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_file, output_folder
from tegotae.systems.controller_file import SUFFIX

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


_NEEDED = (*(name for name in _WORDS if name != "ended"), "run", "omega_t", "best_fitness")
"""Columns that every table has, older ones too. Which metrics it holds is the table's affair."""

_ROW = ("model", "run", "sample", "training_budget", "omega")
"""The columns, of those that a table has, that name a row; a row that is there twice would count
twice."""

_KIND = "table that python -m research.reproduction export wrote"


def write_study_csv(table: StudyTable, path: Path) -> None:
    """Write the table as CSV; undefined numbers are empty."""
    tables.write_csv(output_file(path), table.columns)


def csv_of(table: StudyTable) -> str:
    """Return the table as the text of a CSV file; undefined numbers are empty."""
    return tables.csv_text(table.columns)


def write_study_parquet(table: StudyTable, path: Path) -> None:
    """Write the table as Parquet (extra "study").

    Raises:
        TegotaeError: if pyarrow is not installed or the file cannot be written.
    """
    tables.write_parquet(path, table.columns)


def read_study_csv(path: Path) -> StudyTable:
    """Read the table that `write_study_csv` wrote, with its metrics.

    Raises:
        TegotaeError: if the file cannot be read, is no such table, or has a run twice.
    """
    cells = tables.read_csv(path, _NEEDED, kind=_KIND)
    columns = {name: _column(path, name, column) for name, column in cells.items()}
    require_once(path, {name: columns[name] for name in _ROW if name in columns})
    return StudyTable(columns)


def _column(path: Path, name: str, cells: np.ndarray) -> np.ndarray:
    if name in _WORDS:
        return cells
    try:
        return (
            np.array([*map(whole_number, cells)])
            if name in ("run", "parameters")
            else tables.parse_numbers(cells)
        )
    except ValueError:
        raise TegotaeError(
            f"{path} is no {_KIND}: its column {name} holds what is no number"
        ) from None


def merge(source: Folder, target: Folder) -> int:
    """Copy the records of one folder that another lacks; return how many.

    Of records that both have and that differ, though their settings are equal, it says so.

    Raises:
        TegotaeError: if the folders hold different studies, or the target is in use or cannot be
            written.
    """
    ours, theirs = target.document, source.document
    try:
        united(ours, theirs)
    except TegotaeError as error:
        raise TegotaeError(
            f"{source.path} and {target.path} hold different studies, with {error}; they cannot "
            "be merged"
        ) from None
    output_folder(target.records)
    with target.locked():
        target.describe(source.document)
        incoming, problems = source.all()
        for message in problems:
            print(f"{source.path}: {message}")
        existing = {record_key(record.configuration): record for record in target.all()[0]}
        engines = {record.engine.partition(",")[0] for record in (*incoming, *existing.values())}
        if len(engines) > 1:
            raise TegotaeError(
                f"the records of {source.path} and {target.path} are of different engines, "
                f"{' and '.join(sorted(engines))}; they cannot be merged"
            )
        for record in incoming:
            counterpart = existing.get(record_key(record.configuration), record)
            if _content(counterpart) != _content(record):
                print(
                    f"{record.model} differs in {source.path} and {target.path}, at equal "
                    f"settings: made with {_made_with(record)}, and with {_made_with(counterpart)}"
                )
        lacking = [r for r in incoming if record_key(r.configuration) not in existing]
        for record in lacking:
            record.result.write(target.records / f"{record_key(record.configuration)}{SUFFIX}")
    return len(lacking)


def _content(record: Record) -> list[bytes]:
    """Return the whole content of a table, to be compared bit for bit."""
    content = {name: value for name, value in vars(record).items() if name != "software"}
    return [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(content)]


def _made_with(record: Record) -> str:
    return ", ".join(f"{name} {version}" for name, version in record.software.items())
