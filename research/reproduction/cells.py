"""Cells of the study's tables: whole numbers, and rows of which there is one."""

from __future__ import annotations

import reprlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import Column


def require_once(path: Path, columns: Mapping[str, Column]) -> None:
    """Raise `TegotaeError` if two rows of a table are alike in these columns.

    Args:
        path: the table's file, for the message.
        columns: the columns that together name a row.
    """
    texts = [[*map(str, np.asarray(column).tolist())] for column in columns.values()]
    rows = Counter(zip(*texts, strict=True))
    row, count = rows.most_common(1)[0]
    if count > 1:
        name = ", ".join(f"{column} {cell}" for column, cell in zip(columns, row, strict=True))
        raise TegotaeError(f"{path} has {count} rows of {name}; it must have one")


def whole_number(text: str) -> int:
    """Return a whole number as text of a table.

    Raises:
        ValueError: for a text that is none.

    Example:
        >>> whole_number("12")
        12
    """
    try:
        return int(text.replace("_", "x"))
    except ValueError:
        raise ValueError(f"{reprlib.repr(text)} is no whole number") from None
