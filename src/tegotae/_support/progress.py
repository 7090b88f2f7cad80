"""Progress of long work, and notes, on standard error."""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import rich.console
from rich import progress
from rich.text import Text

from tegotae._start import QUIET


def _is_quiet() -> bool:
    """Return whether progress and notes are suppressed."""
    return os.environ.get(QUIET, "") not in ("", "0")


def note(line: str) -> None:
    """Print a line on standard error for people, unless they want none."""
    if not _is_quiet():
        print(line, file=sys.stderr, flush=True)


_SECONDS_BETWEEN_LINES = 10.0


class Console(rich.console.Console):
    """A console whose reader may go, as `head` does: that is a `BrokenPipeError`, and no exit."""

    def on_broken_pipe(self) -> None:
        """Leave the end to the command."""
        raise


class Reporter:
    """One piece of long work, `total` steps long."""

    def __init__(
        self, title: str, total: int, console: Console, bar: progress.Progress | None
    ) -> None:
        self._title, self._total, self._console, self._bar = title, total, console, bar
        self._task = bar.add_task(title, total=total, note="") if bar else None
        self._first: tuple[int, float] | None = None
        self._last = -math.inf

    def update(self, count: int, note: str = "") -> None:
        """Report that `done` steps are done; `note` describes the progress."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=count, note=note)
            return
        time_s = time.monotonic()
        if time_s - self._last < _SECONDS_BETWEEN_LINES and count < self._total:
            return
        self._last = time_s
        # The first step often compiles: the pace is that of the steps after it.
        first, begun = self._first = self._first or (count, time_s)
        parts = [self._title, f"{count}/{self._total}", note]
        if count > first and time_s > begun:
            per_s = (count - first) / (time_s - begun)
            parts += [_rate(per_s), f"{(self._total - count) / per_s:.0f} s left"]
        self._console.print(
            "  ".join(filter(None, parts)), highlight=False, markup=False, emoji=False
        )


def _rate(per_s: float) -> str:
    return f"{per_s:.1f}/s" if per_s >= 1.0 else f"{60.0 * per_s:.1f}/min"


class _RateColumn(progress.ProgressColumn):
    def render(self, task: progress.Task) -> Text:
        return Text(_rate(task.speed) if task.speed else "")


@contextmanager
def reporting(title: str, total: int) -> Iterator[Reporter]:
    """Report on stderr during the work, unless the user wants no progress (`_is_quiet`)."""
    console = Console(stderr=True, soft_wrap=True, quiet=_is_quiet())
    if console.quiet or not console.is_terminal:
        yield Reporter(title, total, console, None)
        return
    columns = (
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(bar_width=24),
        progress.MofNCompleteColumn(),
        progress.TextColumn("{task.fields[note]}", markup=False),
        _RateColumn(),
        progress.TimeRemainingColumn(),
    )
    with progress.Progress(*columns, console=console) as bar:
        yield Reporter(title, total, console, bar)
