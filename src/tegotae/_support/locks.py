"""Keeping two programs out of one folder."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tegotae._support.errors import TegotaeError

try:
    import fcntl
except ImportError:  # not on Windows: there two programs must not share a folder
    fcntl = None


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Be the only one at work in a folder; the lock goes with the process, however that ends.

    Nothing is written to the lock's file, `.lock`, and a link in its place is not followed.

    Args:
        folder: one that is there and can be written to.

    Raises:
        TegotaeError: if another run is at work in it, or the lock's file cannot be opened.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder, locked(Path(folder)):
        ...     with locked(Path(folder)):
        ...         pass
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: another run is at work in ...
    """
    place = folder / ".lock"
    try:
        lock = os.open(place, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    except OSError as error:
        linked = error.errno == errno.ELOOP
        why = "it is a link; remove it" if linked else error.strerror
        raise TegotaeError(f"cannot open {place}: {why}") from None
    try:
        try:
            hold(lock)
        except BlockingIOError:
            raise TegotaeError(
                f"another run is at work in {folder}; wait for it, or choose another folder"
            ) from None
        yield
    finally:
        os.close(lock)


def hold(file: int) -> bool:
    """Lock an open file until it is closed; False where the file system has no locks.

    Args:
        file: its descriptor.

    Raises:
        BlockingIOError: if another process holds it.
    """
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True
