"""CSV files of loggers and spreadsheets: encodings, separators, preambles and rows of units."""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path

import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_number

_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
_SEPARATORS = ";\t|,"  # a comma last, since it may be that of decimals
_LOOKED_AT = 200
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_CLOCK = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d.*")


_Rows = dict[int, list[str]]
"""Cells of rows, by the lines of the file that they end on."""


def read_log(path: Path, units: Collection[str] = ()) -> dict[str, pd.Series]:
    """Read the cells of a log as texts: columns by name, indexed by their lines in the file.

    The text may be in UTF-8, UTF-16 or the code page of Western Windows. Lines above the names of
    the columns are left out, a row of units below them goes into the names, as `name [unit]`, and
    decimal commas become points.

    Args:
        path: the file.
        units: those that are known, by which a row of units is recognised.

    Raises:
        TegotaeError: if it cannot be read, or has no names, no rows, rows of unequal length, two
            columns of one name, or commas of two meanings.

    Example:
        >>> _ = Path("walk.csv").write_text("leg 2\\nt_s;y_m\\n0,0;1,2\\n0,1;1,3\\n")
        >>> read_log(Path("walk.csv"))["y_m"].to_dict()
        {3: '1.2', 4: '1.3'}
    """
    try:
        return _columns(_text(path.read_bytes()), {unit.lower() for unit in units})
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, csv.Error) as error:
        raise TegotaeError(f"{path} is no recording: {error}") from None


def is_clock(cell: object) -> bool:
    """Tell a time of day by ISO 8601 from other texts.

    Example:
        >>> is_clock("2026-05-04T09:30:00.005Z"), is_clock("0.005")
        (True, False)
    """
    return _CLOCK.fullmatch(str(cell)) is not None


def _is_value(cell: str) -> bool:
    if _COMMA.fullmatch(cell) or is_clock(cell):
        return True
    try:
        parse_number(cell)
    except ValueError:
        return False
    return True


def _text(content: bytes) -> str:
    """Decode bytes: by their mark, or else as UTF-8, or else as code page 1252."""
    for mark, encoding in _MARKS.items():
        if content.startswith(mark):
            return content.decode(encoding)
    if b"\0" in content:
        little = content[1::2].count(0) > content[::2].count(0)
        return content.decode("utf-16-le" if little else "utf-16-be")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def _separator(lines: list[str]) -> str:
    """Return the separator that divides the most lines at the end into equally many cells, two or
    more.
    """

    def divided(separator: str) -> int:
        widths = Counter(map(len, csv.reader(lines[-_LOOKED_AT:], delimiter=separator)))
        return max((rows for width, rows in widths.items() if width > 1), default=0)

    return max(_SEPARATORS, key=divided)


def _columns(text: str, units: Collection[str]) -> dict[str, pd.Series]:
    """Return the columns of a text; raise ValueError for a text that `read_log` refuses."""
    lines = text.splitlines()
    separator = _separator(lines)
    reader = csv.reader(lines, delimiter=separator)
    stripped = ((reader.line_num, [cell.strip() for cell in row]) for row in reader)
    rows = {line: cells for line, cells in stripped if any(cells)}
    if len(rows) < 2:
        raise ValueError("it has no rows")
    width = Counter(map(len, [*rows.values()][-_LOOKED_AT:])).most_common(1)[0][0]
    numbers = (i for i, cells in rows.items() if len(cells) == width and _most(_is_value, cells))
    first = next(numbers, None)
    if first is None:
        raise ValueError("it has no rows of numbers")
    head = {line: cells for line, cells in rows.items() if line < first}
    if not head:
        raise ValueError(
            f"line {first} holds numbers already; write a line of names with units above it, such "
            "as time_s,height_m"
        )
    names = _names(head, width, units)
    body = {line: cells for line, cells in rows.items() if line >= first}
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{names.count(twice[0])} columns are called {twice[0]!r}")
    for line, cells in body.items():
        if len(cells) != width:
            raise ValueError(
                f"line {line} has {len(cells)} cells, and the others have {width}: a row is cut "
                "short or too long; complete or delete it"
            )
    if separator != ",":
        body = _with_points(body)
    table = pd.DataFrame.from_dict(body, orient="index", columns=names, dtype=object)
    return {str(name): column for name, column in table.items()}


def _most(test: Callable[[str], bool], cells: list[str]) -> bool:
    """Return whether most cells pass a test, of those that are not empty."""
    filled = [cell for cell in cells if cell]
    return 2 * sum(map(test, filled)) > len(filled)


def _names(head: _Rows, width: int, units: Collection[str]) -> list[str]:
    """Return the names of the columns, with their units where a row below has them."""
    *above, last = head
    line, names, row_units = last, head[last], [""] * width
    cells = [cell.strip("[]()") for cell in names]
    is_units = _most(lambda unit: unit.lower() in units, cells)
    if is_units and above and len(head[above[-1]]) == len(names):
        line, names, row_units = above[-1], head[above[-1]], cells
    if len(names) != width:
        raise ValueError(
            f"line {line}, the names, has {len(names)} cells, and the rows below it have {width}; "
            "name every column once"
        )
    plain = [name or f"column {i}" for i, name in enumerate(names)]
    for i, (name, unit) in enumerate(zip(plain, row_units, strict=True)):
        suffix = re.split(r"[_ \[(]", name.rstrip("])"))[-1]
        if unit and suffix.lower() not in units:
            plain[i] = f"{name} [{unit}]"
        elif unit and suffix.lower() != unit.lower():
            raise ValueError(
                f"line {last} says that {name!r} is in {unit!r}, and its name ends in "
                f"{suffix!r}; correct one of them"
            )
    return plain


def _with_points(body: _Rows) -> _Rows:
    """Return the rows with decimal points in place of commas; ValueError where both are in use."""
    commas = next((i for i, cells in body.items() if any(map(_COMMA.fullmatch, cells))), None)
    if commas is None:
        return body
    for line, cells in body.items():
        for cell in cells:
            if "." in cell and _is_value(cell.replace(",", "")) and not is_clock(cell):
                raise ValueError(
                    f"line {commas} has decimal commas, and line {line} has {cell!r}; write all "
                    "numbers with one decimal sign, and without one of thousands"
                )
    return {
        line: [cell.replace(",", ".") if _COMMA.fullmatch(cell) else cell for cell in cells]
        for line, cells in body.items()
    }
