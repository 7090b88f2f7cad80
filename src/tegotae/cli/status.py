"""How a command ends: one line on stderr if it fails, and an exit status."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any

from tegotae._start import INTERRUPTED, end_on_ctrl_c
from tegotae._support.errors import TegotaeError
from tegotae.cli.console import one_line

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
    """Run a command; 0, or another status and one line on stderr that says why.

    The status is 2 for what the command cannot use or do, 1 where the system failed it (such as a
    full disk behind its output), 130 after Ctrl-C, 141 where nobody reads its output any more (and
    no line), and 70 for an error that was not expected. With `TEGOTAE_DEBUG=1` the traceback goes
    before the line.
    """
    try:
        try:
            command()
        except SystemExit:  # after help: whatever was printed, to the last line
            sys.stdout.flush()
            raise
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
    """Whether tracebacks are asked for."""
    return os.environ.get(DEBUG, "") not in ("", "0")


def warn_in_one_line() -> None:
    """Have every warning be a line on standard error, once, without its place in the source.

    Where errors show where they arose (`is_debugging`), warnings do, too.
    """
    shown: set[str] = set()
    in_full = warnings.showwarning

    def show(message: Warning | str, *where: Any, **more: Any) -> None:
        if is_debugging():
            in_full(message, *where, **more)
        elif (line := one_line(str(message))) not in shown:
            shown.add(line)
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
    sys.exit(status)


def _formatted(error: Exception) -> tuple[str, int]:
    """The message of an error, and the exit status."""
    if isinstance(error, TegotaeError):
        return str(error), UNUSABLE_INPUT
    if isinstance(error, MemoryError):  # NumPy's says for what there was none
        why = str(error).strip()
        return _OUT_OF_MEMORY.format(why=f": {why}" if why else ""), UNUSABLE_INPUT
    if "RESOURCE_EXHAUSTED" in str(error):  # of a rollout, whose lanes and frames take it
        return _OUT_OF_DEVICE_MEMORY, UNUSABLE_INPUT
    if isinstance(error, OSError):
        unusable = error.errno in (errno.ENAMETOOLONG, errno.ELOOP)  # a name that no file can have
        return str(error), UNUSABLE_INPUT if unusable else NOT_WRITTEN
    first = (str(error).strip().splitlines() or [""])[0]
    what = f"{type(error).__name__}: {first}" if first else type(error).__name__
    hint = "" if is_debugging() else "run again with --debug for details, and "
    return f"unexpected {what}; {hint}please report it", BUG


def _fail(line: str, status: int) -> int:
    with contextlib.suppress(OSError, ValueError):  # stderr may be full or closed, too
        print(f"tegotae: {one_line(line)}", file=sys.stderr)
    return status


def _discard_output() -> None:
    """Let what is still buffered go nowhere, or Python would fail on it once more at its end."""
    with contextlib.suppress(OSError, ValueError):  # no real file, as in a test
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
