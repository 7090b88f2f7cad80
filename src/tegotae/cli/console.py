"""Printing of the command line: tables, notes, and errors as one line."""

from __future__ import annotations

import codecs
import contextlib
import errno
import gc
import io
import os
import shutil
import sys
import textwrap
import traceback
import warnings
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from rich.cells import cell_len, set_cell_size

from tegotae._start import INTERRUPTED, end_on_ctrl_c
from tegotae._support.errors import TegotaeError, shortened
from tegotae._support.spelling import IN_ASCII

PLAIN = "tegotae.plain"
"""Name of the error handler (`codecs.register_error`) that spells plainly."""

_SPELLINGS = {
    **IN_ASCII,
    **{"⁻": "^-", "¹": "1", "±": "+-", "—": "-", "•": "*", "→": "->", "°": " deg", "λ": "lambda"},
    "\u0307": "'",
    **dict.fromkeys("─━╌╴╶╸╺", "-"),
    **dict.fromkeys("│┃╎", "|"),
    **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼╞╡╪", "+"),
}


def make_safe() -> None:
    """Let standard output and error replace characters that they cannot show, instead of
    failing.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=PLAIN)


def one_line(text: str) -> str:
    r"""Return a text in one line, with control characters made visible.

    Example:
        >>> print(one_line("no file\ncalled \x1b[31mred"))
        no file called \x1b[31mred
    """
    joined = " ".join(shortened(text).split())
    return "".join(c if c.isprintable() or c == " " else _escaped(c) for c in joined)


def printable(text: str, encoding: str) -> str:
    """Return a text as a console of this encoding shows it, so that its width is known.

    Example:
        >>> printable("CoT⁻¹ [m/J]", "ascii")
        'CoT^-1 [m/J]'
    """
    text = "".join(c if c.isprintable() else _escaped(c) for c in text)
    return text.encode(encoding, PLAIN).decode(encoding)


def _escaped(character: str) -> str:
    return (
        character.encode("ascii", "backslashreplace").decode()
        if ord(character) > 126
        else (f"\\x{ord(character):02x}")
    )


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_SPELLINGS.get(c, _escaped(c)) for c in lacking), error.end


codecs.register_error(PLAIN, _plainly)


WIDTH = 80
"""Width of lines and tables where the output is no terminal [columns]."""


def print_rows(columns: Iterable[str], rows: Iterable[Iterable[str]], *, key: int = 1) -> None:
    """Print a table; on a terminal too narrow for it, as several, one below the other.

    Each part begins with the key columns, so that its rows are distinct. Where the output is
    no terminal the table is one, as wide as it needs to be. A cut number is worse than a long line.
    A table of one row that does not fit is a list, a line per column.

    Args:
        columns: headings.
        rows: rows of the table, one text a column.
        key: number of columns, the first ones, that name the row.
    """
    plain, on_screen = (
        partial(printable, encoding=sys.stdout.encoding or "utf-8"),
        sys.stdout.isatty(),
    )
    width = shutil.get_terminal_size().columns if on_screen else WIDTH
    lines = [[plain(cell) for cell in row] for row in (columns, *rows)]
    table, across = map(_aligned, (zip(*lines, strict=True), lines))
    if len(lines) == 2 and _width(table) > width >= _width(across):
        table = across
    parts = [table[:key]]
    for column in table[key:]:
        if on_screen and len(parts[-1]) > key and _width([*parts[-1], column]) > width:
            parts.append(table[:key])
        parts[-1] = [*parts[-1], column]
    for part in parts:
        print(*("  " + "   ".join(cells) for cells in zip(*part, strict=True)), "", sep="\n")


def _aligned(columns: Iterable[Sequence[str]]) -> list[list[str]]:
    """Return columns of cells as wide as the widest one, with a line below the heading."""
    widths = [(column, max(map(cell_len, column))) for column in columns]
    return [
        [set_cell_size(cell, wide) for cell in (column[0], "─" * wide, *column[1:])]
        for column, wide in widths
    ]


def _width(columns: Sequence[Sequence[str]]) -> int:
    """Return the width of columns with the blanks around and between them [letters]."""
    return 1 + sum(3 + cell_len(column[0]) for column in columns)


def print_text(text: str) -> None:
    """Print a paragraph in lines that fit a screen, or a command in one line."""
    print(text if text.startswith("tegotae ") else textwrap.fill(text, WIDTH))


NOT_WRITTEN = 1
"""The system failed a command: a full disk, a missing file."""
UNUSABLE_INPUT = 2
BUG = 70
"""An error that no part of the program expected, as in BSD's sysexits.h."""
BROKEN_PIPE = 141
"""The reader of the output has gone, by convention: 128 and the signal's number."""
DEBUG = "TEGOTAE_DEBUG"
"""Environment variable that has errors show where they arose; the switch --debug sets it."""

_OUT_OF_DEVICE_MEMORY = "out of memory; use fewer lanes or a shorter duration"
_OUT_OF_MEMORY = "out of memory{why}; ask for less, or free some"


def exit_status(command: Callable[[], None]) -> int:
    """Run a command; return 0, or another status after one line on stderr with the reason.

    The status is 2 for what the command cannot use or do, 1 where the system failed it (such as a
    full disk behind its output), 130 after Ctrl-C, 141 where nobody reads its output any more (and
    no line), and 70 for an error that was not expected. With `TEGOTAE_DEBUG=1` the traceback goes
    before the line.
    """
    try:
        command()
        sys.stdout.flush()
    except KeyboardInterrupt as stop:
        return _fail(str(stop) or "interrupted", INTERRUPTED)
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        _discard_output()
        return BROKEN_PIPE
    except Exception as error:
        if is_debugging():
            traceback.print_exc()
        if isinstance(error, OSError) and not isinstance(error, TegotaeError):
            _discard_output()
        return _fail(*_formatted(error))
    return 0


def is_debugging() -> bool:
    """Return True if the user wants tracebacks."""
    return os.environ.get(DEBUG, "") not in ("", "0")


def warn_in_one_line() -> None:
    """Print every warning once, as a line on standard error, without its place in the source.

    Where errors show where they arose (`is_debugging`), warnings do, too.
    """
    printed: set[str] = set()
    in_full = warnings.showwarning

    def show(message: Warning | str, *where: Any, **details: Any) -> None:
        if is_debugging():
            in_full(message, *where, **details)
        elif (line := one_line(str(message))) not in printed:
            printed.add(line)
            with contextlib.suppress(OSError, ValueError):  # stderr may be full or closed
                print(f"tegotae: warning: {line}", file=sys.stderr)

    warnings.showwarning = show


def leave(status: int) -> None:
    """End the process. After Ctrl-C at once: XLA aborts if Python takes it down while it works."""
    end_on_ctrl_c()  # one more would be a traceback
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.flush()
    if status == INTERRUPTED:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
        os._exit(status)
    gc.freeze()  # the process ends: nothing is looked through once more
    sys.exit(status)


def _formatted(error: Exception) -> tuple[str, int]:
    """Return the message of an error, and the exit status."""
    if isinstance(error, TegotaeError):
        return str(error), UNUSABLE_INPUT
    if isinstance(error, MemoryError):  # NumPy's says for what there was none
        reason = str(error).strip()
        return _OUT_OF_MEMORY.format(why=f": {reason}" if reason else ""), UNUSABLE_INPUT
    if "RESOURCE_EXHAUSTED" in str(error):  # of a rollout, whose lanes and frames take it
        return _OUT_OF_DEVICE_MEMORY, UNUSABLE_INPUT
    if isinstance(error, OSError):
        unusable = error.errno in (errno.ENAMETOOLONG, errno.ELOOP)  # a name that no file can have
        return str(error), UNUSABLE_INPUT if unusable else NOT_WRITTEN
    first = (str(error).strip().splitlines() or [""])[0]
    message = f"{type(error).__name__}: {first}" if first else type(error).__name__
    hint = "" if is_debugging() else "run again with --debug for details, and "
    return f"unexpected {message}; {hint}please report it", BUG


def _fail(line: str, status: int) -> int:
    with contextlib.suppress(OSError, ValueError):  # stderr may be full or closed, too
        print(f"tegotae: {one_line(line)}", file=sys.stderr)
    return status


def _discard_output() -> None:
    """Discard buffered output; Python would fail on it once more at its end."""
    with contextlib.suppress(OSError, ValueError):  # no real file, as in a test
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
