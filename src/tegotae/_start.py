"""The first moments of the program, before anything long is imported."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

QUIET = "TEGOTAE_QUIET"
"""Environment variable that leaves out progress and notes; the switch --quiet sets it."""
INTERRUPTED = 130
"""Exit status after Ctrl-C, by convention: 128 and the signal's number."""


def end_on_ctrl_c() -> None:
    """Let Ctrl-C end the process in silence from here on; a process that ignores it still does.

    For a program that is being loaded; `ready` ends this.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def ready() -> None:
    """Let Ctrl-C raise `KeyboardInterrupt` from here on, which commands report in their own
    words."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def open_streams() -> None:
    """Replace a closed standard stream (`tegotae models >&-`) by one without a reader.

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
        descriptor = os.open(os.devnull, os.O_RDWR)
        if descriptor != number:
            os.dup2(descriptor, number)
            os.close(descriptor)


def _end(signum: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)
