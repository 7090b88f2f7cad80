"""The first moments of the program, before anything long is imported."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from types import FrameType

INTERRUPTED = 130
"""Exit status after Ctrl-C, by convention: 128 and the signal's number."""


def prepare() -> None:
    """Let Ctrl-C end the program in silence while it is loaded, and give it all three streams.

    Of effect only where `tegotae` is the program that runs; a program that imports it keeps its own
    ways. `ready` ends the first of the two.
    """
    if is_program(sys.argv, sys.orig_argv):
        open_streams()
        end_on_ctrl_c()


def end_on_ctrl_c() -> None:
    """From here on Ctrl-C ends the process in silence; where it is ignored, it stays so."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def ready() -> None:
    """From here on Ctrl-C raises `KeyboardInterrupt`, which commands tell in their own words."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def is_program(arguments: list[str], whole: list[str]) -> bool:
    """Whether a command line is that of `tegotae` or of `python -m tegotae`.

    Args:
        arguments: as `sys.argv` has them.
        whole: the same with what the interpreter was told, as `sys.orig_argv` has them.

    Example:
        >>> is_program(["-m", "models"], ["python", "-m", "tegotae", "models"])
        True
        >>> is_program(["-m"], ["python", "-m", "pytest"])
        False
        >>> is_program(["/usr/bin/tegotae", "models"], ["python", "/usr/bin/tegotae", "models"])
        True
    """
    first = arguments[0] if arguments else ""
    if first == "-m":  # as long as the module is looked for, which imports its package
        named = whole[whole.index("-m") + 1 :] if "-m" in whole else []
        return bool(named) and named[0].split(".")[0] == "tegotae"
    return Path(first).stem == "tegotae"


def open_streams() -> None:
    """Have a closed standard stream (`tegotae models >&-`) be one that nobody looks at.

    Python has none in its place, and the next file to be opened would take its number: what is
    printed would go into that file.
    """
    for name, number, mode in (("stdin", 0, "r"), ("stdout", 1, "w"), ("stderr", 2, "w")):
        if getattr(sys, name) is None:
            _occupy(number)
            stream = open(number, mode, encoding="utf-8", closefd=False)  # noqa: SIM115 - for good
            setattr(sys, name, stream)


def _occupy(number: int) -> None:
    try:
        os.fstat(number)
    except OSError:
        nothing = os.open(os.devnull, os.O_RDWR)
        if nothing != number:
            os.dup2(nothing, number)
            os.close(nothing)


def _end(signum: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)
