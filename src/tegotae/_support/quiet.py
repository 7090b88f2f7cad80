"""Whether the user wants results and errors alone."""

from __future__ import annotations

import os
import sys

QUIET = "TEGOTAE_QUIET"
"""Environment variable that leaves out progress and notes; the switch --quiet sets it."""


def is_quiet() -> bool:
    """Whether progress and notes are left out."""
    return os.environ.get(QUIET, "") not in ("", "0")


def note(line: str) -> None:
    """Print a line on standard error, for people, unless they want none."""
    if not is_quiet():
        print(line, file=sys.stderr, flush=True)
