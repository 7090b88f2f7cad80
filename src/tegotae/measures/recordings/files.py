"""Columns of numbers from a file: CSV, NumPy's .npz, or Parquet."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from tegotae._support.arrays import read_arrays
from tegotae._support.errors import TegotaeError
from tegotae._support.optional_dependencies import require
from tegotae._support.tables import number, read_csv
from tegotae.measures.recordings.quantities import QUANTITIES, split

MOST_BYTES = 2**30
"""Of all arrays of a .npz together [bytes]: hours of a robot's log."""
_NEEDED = {*QUANTITIES["time"].names, *QUANTITIES["height"].names}


def read_columns(path: Path | str) -> dict[str, np.ndarray]:
    """The columns of a file by name, as they are: texts or numbers.

    Args:
        path: a .csv with a row of names, a .npz of arrays of one dimension, or a .parquet (extra
            "study").

    Raises:
        TegotaeError: for another ending, a file that cannot be read, or arrays of other shapes.
        MissingExtraError: for Parquet without pyarrow.

    Example:
        >>> np.savez("walk.npz", time_s=np.arange(3) * 0.01, height_m=np.ones(3))
        >>> list(read_columns("walk.npz"))
        ['time_s', 'height_m']
    """
    path = Path(path)
    read = FORMATS.get(path.suffix.lower())
    if read is None:
        raise TegotaeError(
            f"{path} is no recording: its name must end in {', '.join(FORMATS)}, and it ends in "
            f"{path.suffix or 'nothing'}"
        )
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    return read(path)


def numbers_of(name: str, column: Iterable) -> np.ndarray:
    """A column as float64, NaN where a cell is empty.

    Raises:
        TegotaeError: for a cell that is no number.
    """
    cells = np.asarray(column)
    if cells.dtype.kind in "fiub":
        return cells.astype(float)
    found = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells.tolist()):
        text = str(cell).strip()
        try:
            found[row] = number(text) if text and cell is not None else np.nan
        except ValueError:
            raise TegotaeError(f"{name} is {text!r} in row {row}, which is no number") from None
    return found


def _csv(path: Path) -> dict[str, np.ndarray]:
    return read_csv(path, kind="recording")


def _npz(path: Path) -> dict[str, np.ndarray]:
    try:
        columns = read_arrays(path, MOST_BYTES)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise TegotaeError(f"{path} is no recording: no .npz of plain arrays ({error})") from None
    # One number, such as a rate, is no column; and one column more in a matrix is still one.
    columns = {name: np.squeeze(column) for name, column in columns.items()}
    kept = {name: column for name, column in columns.items() if column.ndim == 1}
    for name, column in columns.items():
        if column.ndim > 1 and split(name)[0] in _NEEDED:
            raise TegotaeError(
                f"{path} is no recording: {name} has the shape {column.shape}; it must be one "
                "number a sample"
            )
    if not kept:
        raise TegotaeError(f"{path} is no recording: it holds no array of one dimension")
    return kept


def _parquet(path: Path) -> dict[str, np.ndarray]:
    arrow = require("pyarrow", "study")
    parquet = require("pyarrow.parquet", "study")
    try:
        table = parquet.read_table(path)
    except (OSError, arrow.ArrowException) as error:
        first = str(error).splitlines()[0]
        raise TegotaeError(f"{path} is no recording: {first}") from None
    return {
        name: np.array(table.column(name).to_pylist(), dtype=object) for name in table.column_names
    }


FORMATS: dict[str, Callable[[Path], dict[str, np.ndarray]]] = {
    ".csv": _csv,
    ".npz": _npz,
    ".parquet": _parquet,
}
"""Who reads which ending."""
