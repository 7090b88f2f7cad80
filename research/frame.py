"""Read and write the tables of studies: a file each, beside their pages."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.files import output_folder, write_atomically
from tegotae._support.tables import csv_text


def write_text(file: Path, text: str) -> None:
    """Write a text, in a folder that need not be there."""
    output_folder(file.parent)
    write_atomically(file, text)


def write_rows(
    file: Path, rows: Sequence[dict[str, Any]], *, digits: int, by: Sequence[str] = ()
) -> None:
    """Write rows as a table, if there are any.

    Args:
        file: the table.
        rows: all with the columns of the first, or some of them.
        digits: significant digits of numbers.
        by: columns that say what a row is of: rows of the file that are of something else stay,
            so that a part of a study can be done again.
    """
    if not rows:
        return
    text = csv_text(
        {title: [row.get(title, np.nan) for row in rows] for title in rows[0]}, digits=digits
    )
    if by and file.exists():
        previous, updated = (
            pd.read_csv(source, dtype=str, keep_default_na=False)
            for source in (file, io.StringIO(text))
        )
        keys = [pd.MultiIndex.from_frame(table[list(by)]) for table in (previous, updated)]
        merged = pd.concat([previous[~keys[0].isin(keys[1])], updated])
        text = merged.to_csv(index=False, lineterminator="\n")
    write_text(file, text)
