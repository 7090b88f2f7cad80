"""Long work in parts: what is done is kept in a file, and the same work continues from there."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support.engines import selected
from tegotae._support.errors import TegotaeError
from tegotae._support.files import read_arrays, write_atomically

_MOST_BYTES = 2**30

Columns = dict[str, np.ndarray]
"""What a part gives, lanes last."""


def in_sequence(
    count: int,
    part: Callable[[Sequence[Columns]], Columns],
    *,
    kept: Path | None = None,
    settings: Mapping[str, object] | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Columns]:
    """Do the parts of some work one after another, those that a file keeps from before left out.

    Args:
        count: how many parts there are.
        part: does the next of them, given what the earlier ones gave.
        kept: the file; nothing is kept without. It is removed at the end.
        settings: all that the work depends on, as JSON values: a file of other work does not count.
        progress: is called with how many are done.

    Raises:
        TegotaeError: if the file cannot be written.
        KeyboardInterrupt: after Ctrl-C; it says what is kept.

    Example:
        >>> in_sequence(2, lambda done: {"earlier": np.array([len(done)])})
        [{'earlier': array([0])}, {'earlier': array([1])}]
    """
    key = json.dumps({"engine": selected(), **(settings or {})}, sort_keys=True, default=str)
    done = [] if kept is None else _read(kept, key)[:count]
    progress(len(done))
    try:
        while len(done) < count:
            done.append(part(done))
            if kept is not None and len(done) < count:
                _write(kept, key, done)
            progress(len(done))
    except KeyboardInterrupt:
        if kept is None or not done:
            raise
        raise KeyboardInterrupt(
            f"interrupted; {kept} keeps {len(done)} of {count} parts, the same command goes on "
            "from there"
        ) from None
    if kept is not None:
        with contextlib.suppress(OSError):
            kept.unlink()
    return done


def in_parts(count: int, part: Callable[[int], Columns], **more: Any) -> list[Columns]:
    """The same of parts that do not depend on each other.

    Args:
        count: how many parts there are.
        part: does one of them, given its number.
        more: arguments of `in_sequence`.

    Raises:
        TegotaeError: if the file cannot be written.
        KeyboardInterrupt: after Ctrl-C; it says what is kept.

    Example:
        >>> in_parts(2, lambda number: {"square": np.array([number**2])})
        [{'square': array([0])}, {'square': array([1])}]
    """
    return in_sequence(count, lambda done: part(len(done)), **more)


def _write(path: Path, key: str, done: list[Columns]) -> None:
    stream = io.BytesIO()
    arrays = {f"{i}/{name}": x for i, part in enumerate(done) for name, x in part.items()}
    arrays |= {"key": np.array(key), "count": np.array(len(done))}
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    write_atomically(path, stream.getvalue())


def _read(path: Path, key: str) -> list[Columns]:
    try:
        arrays = read_arrays(path, _MOST_BYTES)
        if str(arrays["key"]) != key:
            return []
        count = int(arrays["count"])
        if not 0 <= count < len(arrays):  # a part has an array at least
            raise ValueError
        parts: dict[int, Columns] = {number: {} for number in range(count)}
        for entry, values in arrays.items():
            number, slash, name = entry.partition("/")
            if slash:
                parts[int(number)][name] = values
        return list(parts.values())
    except FileNotFoundError:
        return []
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, TypeError, KeyError):
        raise TegotaeError(f"{path} cannot be read; remove it to start again") from None
