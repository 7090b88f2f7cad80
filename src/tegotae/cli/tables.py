"""Tables on the screen, never cut."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from functools import partial

from rich import box
from rich.cells import cell_len
from rich.table import Table

from tegotae._support.progress import Console
from tegotae.cli.console import shown

WIDTH = 80
"""That lines and tables are to fit where the output is no terminal [columns]."""
_PADDING = 3
"""Blanks around a cell, and to the next."""


def print_rows(
    columns: Iterable[str], rows: Iterable[Iterable[str]], *, key: int = 1, turned: bool = False
) -> None:
    """Print a table; on a terminal too narrow for it, as several, one below the other.

    Each part begins with the key columns, so that its rows are distinct. Where the output is
    no terminal the table is one, as wide as it needs to be. A cut number is worse than a long line.

    Args:
        columns: the headings.
        rows: of the table, one text a column.
        key: how many columns, the first ones, name the row.
        turned: print a line per column, and a column per row, where that makes the table fit.
    """
    # A name in a cell is no markup, whatever brackets it has.
    console, wide = (
        Console(highlight=False, markup=False, emoji=False, width=width) for width in (None, 10_000)
    )
    plain = partial(shown, encoding=console.encoding)
    columns, rows = tuple(map(plain, columns)), [tuple(map(plain, row)) for row in rows]
    if turned and not _fits(columns, rows, console):
        across = list(zip(columns, *rows, strict=True))
        if _fits(across[0], across[1:], console):
            columns, rows = across[0], across[1:]
    parts = [tuple(range(len(columns)))]
    if console.is_terminal:
        parts = fitting(column_widths(columns, rows), console.width, key)
    for part in parts:
        table = Table(box=box.SIMPLE_HEAD)
        for i in part:
            table.add_column(columns[i], no_wrap=True)
        for row in rows:
            table.add_row(*(row[i] for i in part))
        console.width = max(console.width, wide.measure(table).maximum)
        console.print(table)


def _fits(columns: Sequence[str], rows: Sequence[Sequence[str]], console: Console) -> bool:
    width = console.width if console.is_terminal else WIDTH
    return 1 + sum(column_widths(columns, rows)) <= width


def print_text(text: str) -> None:
    """Print a paragraph in lines that fit a screen."""
    print(textwrap.fill(text, WIDTH))


def column_widths(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    """How wide each column is on the screen, in cells of a letter."""
    return [
        _PADDING + max(cell_len(text) for text in (name, *(row[i] for row in rows)))
        for i, name in enumerate(columns)
    ]


def fitting(widths: Sequence[int], width: int, key: int = 1) -> list[tuple[int, ...]]:
    """Which columns go into which part of a table, so that each fits a width if it can.

    Args:
        widths: of the columns.
        width: of the screen.
        key: the first so many columns begin every part.

    Example:
        >>> fitting([10, 6, 6, 6], width=23)
        [(0, 1, 2), (0, 3)]
    """
    keys = tuple(range(min(key, len(widths))))
    edges = 1  # of the table's box
    parts = [list(keys)]
    for i in range(len(keys), len(widths)):
        part = parts[-1]
        wide = edges + sum(widths[j] for j in part) + widths[i]
        if wide > width and len(part) > len(keys):
            parts.append([*keys, i])
        else:
            part.append(i)
    return [tuple(part) for part in parts]
