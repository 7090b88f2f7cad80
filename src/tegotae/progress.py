"""Showing people how far long work is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

_SECONDS_BETWEEN_LINES = 10.0


class Reporter:
    """One piece of long work, `total` steps long."""

    def __init__(self, title: str, total: int, console: Console, bar: Progress | None) -> None:
        self._title, self._total, self._console, self._bar = title, total, console, bar
        self._task = bar.add_task(title, total=total, note="") if bar else None
        self._begun = self._last = time.monotonic()
        self._first: int | None = None

    def update(self, done: int, note: str = "") -> None:
        """`done` steps are done; `note` says how it goes."""
        if self._first is None:
            self._first = done - 1
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=done, note=note)
            return
        now = time.monotonic()
        if now - self._last < _SECONDS_BETWEEN_LINES and done < self._total:
            return
        self._last = now
        pace = (now - self._begun) / max(done - self._first, 1)
        left = pace * (self._total - done)
        self._console.print(
            f"{self._title}  {done}/{self._total}  {note}  {left:.0f} s left", highlight=False
        )


@contextmanager
def reporting(title: str, total: int) -> Iterator[Reporter]:
    """Report on stderr while the work goes on."""
    console = Console(stderr=True, soft_wrap=True)
    if not console.is_terminal:
        yield Reporter(title, total, console, None)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        yield Reporter(title, total, console, bar)
