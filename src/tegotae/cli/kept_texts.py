"""Help and completion are the same until the package changes: they are made once, and kept."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import tegotae
from tegotae._support import compiled

HELP = frozenset({"-h", "--help"})
"""Options that want help."""
_NAME = re.compile(r"[\w-]+")


def is_help(words: Sequence[str]) -> bool:
    """Return True if words want help that the package's files alone decide.

    A file or a part of a user is none of these: a word with any other character than a name's may
    be a file's, as `AR@robot.toml` is.

    Example:
        >>> is_help(["train", "ART", "--help"]), is_help(["train", "ART"])
        (True, False)
        >>> is_help(["train", "mine.py:experiment", "--help"])
        False
    """
    plain = all(_NAME.fullmatch(word) and not os.path.exists(word) for word in words)
    return plain and not HELP.isdisjoint(words)


def kept(words: Sequence[str], make: Callable[[], str]) -> str:
    """Return a text that the package's files alone decide, from the store if it has it.

    Args:
        words: words of its command.
        make: function that makes it.
    """
    key = compiled.key_of(_package(), *words)
    stored = compiled.stored_code(key)
    if stored is not None:
        return stored.decode()
    text = make()
    compiled.store_code(key, text.encode())
    return text


def _package() -> str:
    """Return the files of the package and of its robots with the times of their last changes."""
    folder = Path(tegotae.__file__).parent
    folders = folder, folder.with_name("tegotae_robots")
    kinds = "*.py", "*.toml", "*.json"
    files = sorted(file for kind in kinds for x in folders for file in x.rglob(kind))
    return " ".join(f"{path} {path.stat().st_mtime_ns}" for path in files)
