"""Tables as files and text: CSV and Parquet.

Columns of equal length by name. A number is written so that it is read again to the last bit, or
with fewer digits where they are asked for; what is undefined (NaN) is an empty cell.
"""

from __future__ import annotations

import csv
import io
import reprlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tegotae._support.errors import TegotaeError, require
from tegotae._support.files import output_file, write_atomically

Column = npt.ArrayLike | Sequence[object]
"""The cells of a column: an array, or a list of numbers and texts."""


def csv_text(columns: Mapping[str, Column], *, digits: int | None = None) -> str:
    r"""Return a table as the text of a CSV file.

    Args:
        columns: arrays or lists of one length, by name.
        digits: significant digits of the numbers that are not whole; all by default.

    Example:
        >>> csv_text({"run": [0, 1], "t0_s": [0.1, float("nan")]})
        'run,t0_s\n0,0.1\n1,\n'
    """
    from pandas import DataFrame  # slow to import

    as_written = None if digits is None else f"%.{digits}g"
    frame = DataFrame(_plain(columns))
    return frame.to_csv(index=False, lineterminator="\n", float_format=as_written)


def write_csv(path: Path, columns: Mapping[str, Column], *, digits: int | None = None) -> None:
    """Write a table as CSV, whole or not at all.

    Raises:
        TegotaeError: if it cannot be written.
    """
    write_atomically(path, csv_text(columns, digits=digits))


def write_parquet(path: Path, columns: Mapping[str, Column]) -> None:
    """Write a table as Parquet (extra "study").

    Raises:
        TegotaeError: if pyarrow is not installed or the file cannot be written.
    """
    arrow = require("pyarrow", "study")
    parquet = require("pyarrow.parquet", "study")
    stream = io.BytesIO()
    # Without pandas, which would make nothing (null) of what is undefined (NaN).
    parquet.write_table(arrow.table(_plain(columns)), stream)
    write_atomically(output_file(path), stream.getvalue())


def read_csv(
    path: Path, needed: Iterable[str] = (), *, kind: str = "table"
) -> dict[str, np.ndarray]:
    """Return the cells of a CSV file as texts: arrays of one length by the columns' names.

    Args:
        path: the file.
        needed: columns that it must have.
        kind: what it should be, for the message.

    Raises:
        TegotaeError: if it cannot be read, has no rows, rows of unequal length, two columns of one
            name, or no such column.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError:
        raise TegotaeError(f"{path} is no {kind}: it is not text in UTF-8") from None
    try:
        columns = parse_csv(text)
    except ValueError as error:
        raise TegotaeError(f"{path} is no {kind}: {error}") from None
    lacking = [name for name in needed if name not in columns]
    if lacking:
        raise TegotaeError(f"{path} is no {kind}: it has no column {', '.join(lacking)}")
    return columns


def parse_csv(text: str) -> dict[str, np.ndarray]:
    r"""Return the cells of a CSV text, as texts by the columns' names.

    Raises:
        ValueError: if it has no rows, rows of unequal length, or two columns of one name.

    Example:
        >>> parse_csv("run,t0_s\n0,0.1\n")["t0_s"].tolist()
        ['0.1']
    """
    try:
        lines = csv.reader(io.StringIO(text.removeprefix("\ufeff")))
        rows = [row for row in lines if len(row) > 1 or "".join(row).strip()]
    except csv.Error as error:
        raise ValueError(str(error)) from None
    if len(rows) < 2:
        raise ValueError("it has no rows")
    names = [name or f"column {i}" for i, name in enumerate(rows[0])]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{names.count(twice[0])} columns are called {twice[0]!r}")
    lengths = {len(row) for row in rows}
    if min(lengths) < len(names):
        raise ValueError("a row is cut short")
    if max(lengths) > len(names):
        raise ValueError(f"a row has {max(lengths)} cells, and there are {len(names)} columns")
    return {name: np.array(cells) for name, *cells in zip(names, *rows[1:], strict=True)}


def parse_number(text: str) -> float:
    """Parse a number as tables, options and names write it; Python would read 0.99_5 as 0.995.

    Raises:
        ValueError: for a text that is no number.

    Example:
        >>> parse_number("0.995")
        0.995
    """
    if "_" in text:
        raise ValueError(f"{reprlib.repr(text)} is no number: it has an underscore")
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{reprlib.repr(text)} is no number") from None


def parse_numbers(cells: Iterable[str]) -> np.ndarray:
    """Return cells as float64, exact to the last written bit; NaN where empty.

    Raises:
        ValueError: for a cell that is no number.

    Example:
        >>> parse_numbers(["0.1", ""]).tolist()
        [0.1, nan]
    """
    return np.array([parse_number(cell) if cell else np.nan for cell in cells], float)


def _plain(columns: Mapping[str, Column]) -> dict[str, np.ndarray]:
    """Return the columns as arrays, numbers in double precision with all their digits."""
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    return {name: a.astype(float) if a.dtype.kind == "f" else a for name, a in arrays.items()}
