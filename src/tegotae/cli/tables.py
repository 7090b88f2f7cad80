"""Tables on the screen, never cut."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table


def print_rows(columns: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Print a table as wide as it needs to be: a cut number is worse than a long line."""
    table = Table(*columns, box=box.SIMPLE_HEAD)
    for row in rows:
        table.add_row(*row)
    for column in table.columns:
        column.no_wrap = True
    console = Console(highlight=False)
    console.width = max(console.width, Console(width=10_000).measure(table).maximum)
    console.print(table)
