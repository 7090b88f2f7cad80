"""Frame of all studies: cells of a plan are measured once into kept tables, from which a report
makes the texts and figures of the page.

A study is a module with a function for each of its commands:

    def run(seeds: int = 10) -> None: ...   # measures the cells that its table lacks
    def report() -> None: ...               # texts and figures of the kept tables

    if __name__ == "__main__":
        main(run, report)
"""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import tyro

from tegotae._support.files import output_folder, write_atomically
from tegotae._support.tables import csv_text
from tegotae.cli.console import exit_status
from tegotae.measures.statistics import interval

Row = dict[str, Any]
Names = Annotated[tuple[str, ...], tyro.conf.Positional]
"""Words of a command without an option's name."""
Place = Annotated[Path, tyro.conf.Positional]
"""File or folder of a command without an option's name."""


def main(*commands: Callable[..., Any], **named: Callable[..., Any]) -> None:
    """Run the command that the command line names, and end the program; a single one has no name.

    Args:
        commands: functions with typed keywords, or dataclasses with a method `run`.
        named: the same, with the words of the command line as keywords.
    """
    text = sys.modules["__main__"].__doc__

    def call() -> None:
        if len(commands) == 1 and not named:
            program = tyro.cli(commands[0], description=text)
        else:
            by_name = {command.__name__.lower().replace("_", "-"): command for command in commands}
            program = tyro.extras.subcommand_cli_from_dict(by_name | named, description=text)
        if hasattr(program, "run"):
            program.run()

    sys.exit(exit_status(call))


def write_text(file: Path, text: str) -> None:
    """Write a text, in a folder that need not be there."""
    output_folder(file.parent)
    write_atomically(file, text)


def write_rows(file: Path, rows: Sequence[Row], *, digits: int, by: Sequence[str] = ()) -> None:
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


@dataclass(frozen=True)
class Table:
    """Kept table of a study.

    Args:
        file: its place.
        by: columns that identify a cell, the rows that are measured together.
        digits: significant digits of its numbers.
    """

    file: Path
    by: tuple[str, ...]
    digits: int = 4

    def read(self) -> pd.DataFrame:
        """Return the kept rows; none if the file is not there."""
        if not self.file.exists():
            return pd.DataFrame(columns=list(self.by))
        return pd.read_csv(self.file)

    def missing(self, cells: Iterable[Sequence[Any]]) -> list[Sequence[Any]]:
        """Return the cells without rows, each the values of the columns `by`."""
        finished = set(map(tuple, self.read()[list(self.by)].to_numpy()))
        return [cell for cell in cells if tuple(cell) not in finished]

    def measure(
        self, cells: Iterable[Sequence[Any]], rows_of: Callable[..., Sequence[Row]]
    ) -> None:
        """Measure the missing cells, one after the other; a stopped run continues from there."""
        for cell in self.missing(cells):
            write_rows(self.file, rows_of(*cell), digits=self.digits, by=self.by)
            print(*cell, flush=True)


def markdown_table(rows: Sequence[Sequence[object]]) -> str:
    """Return rows of cells as a table in Markdown, the first being its head."""
    lines = [
        "|" + "".join(f" {cell} |" if f"{cell}" else " |" for cell in cells).rstrip()
        for cells in rows
    ]
    return "\n".join([lines[0], "|" + "-|" * len(rows[0]), *lines[1:]]) + "\n"


def with_interval(
    values: Any,
    form: str = ".2f",
    within: tuple[float, float] = (-math.inf, math.inf),
) -> str:
    """Return the mean of runs with its 95 % interval, of those that are numbers."""
    finite = np.asarray(values, float)
    finite = finite[np.isfinite(finite)]
    if len(finite) < 2:
        return f"{finite[0]:{form}}" if len(finite) else "–"
    estimate = interval(finite, within=within)
    return f"{estimate.mean:{form}} [{estimate.low:{form}}, {estimate.high:{form}}]"
