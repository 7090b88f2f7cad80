"""Help and completion are the same until the package changes: they are made once, and kept."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import tegotae
from tegotae._support import compiled
from tegotae.cli.console import exit_status

_LOOKS = ("NO_COLOR", "FORCE_COLOR", "TERM", "COLORTERM", "TTY_COMPATIBLE")

_NAME = re.compile(r"[\w-]+")


def is_text(words: Sequence[str]) -> bool:
    """Return True if words want a text that the package's files alone decide.

    A file or a part of a user is none of these: a word with any other character than a name's may
    be a file's, as `AR@robot.toml` is.

    Example:
        >>> is_text(["train", "ART", "--help"]), is_text(["train", "ART"])
        (True, False)
        >>> is_text(["train", "mine.py:experiment", "--help"])
        False
    """
    asks = "--help" in words or "-h" in words or words[:1] == ["completion"]
    plain = all(_NAME.fullmatch(word) and not os.path.exists(word) for word in words)
    return asks and plain and "--parts" not in words


def print_stored(words: Sequence[str], prog: str, make: Callable[[], int]) -> int:
    """Print a text, from the store if it has it, and return the exit status.

    Args:
        words: words of the command.
        prog: name of the program.
        make: function that prints the text and returns the exit status.

    Raises:
        SystemExit: of status 0 after `--help`.
    """
    looks = [os.environ.get(name, "") for name in _LOOKS]
    width = shutil.get_terminal_size().columns
    key = compiled.key_of(_package(), prog, *words, "", str(width), str(_on_screen()), *looks)
    text = compiled.stored_code(key)
    if text is not None:
        status = exit_status(lambda: print(text.decode(), end=""))
        if not status and {"--help", "-h"} & set(words):
            raise SystemExit(0)
        return status
    copy = _Copy(sys.stdout)
    status: Any = 1
    try:
        with contextlib.redirect_stdout(copy):  # type: ignore[type-var]
            status = make()
    except SystemExit as end:
        status = end.code
        raise
    finally:
        if not status:
            compiled.store_code(key, "".join(copy.text).encode())
    return status


def _on_screen() -> bool:
    return sys.stdout.isatty()


def _package() -> str:
    """Return the files of the package and of its robots with the times of their last changes."""
    folder = Path(tegotae.__file__).parent
    folders = folder, folder.with_name("tegotae_robots")
    kinds = "*.py", "*.toml", "*.json"
    files = sorted(file for kind in kinds for x in folders for file in x.rglob(kind))
    return " ".join(f"{path} {path.stat().st_mtime_ns}" for path in files)


class _Copy:
    """Stream that remembers the text that passes through it."""

    def __init__(self, stream: Any) -> None:
        self.stream, self.text = stream, []

    def write(self, text: str) -> int:
        self.text.append(text)
        return self.stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)
