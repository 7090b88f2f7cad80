"""A folder is for one kind of work, and for one program at a time."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from tegotae._support.errors import TegotaeError
from tegotae._support.files import hold, output_folder


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder for this process alone; the lock ends with the process, however that ends.

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
        reason = "it is a link; remove it" if linked else error.strerror
        raise TegotaeError(f"cannot open {place}: {reason}") from None
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


_EARLIER = ".earlier"


@dataclass(frozen=True)
class WorkKind:
    """A kind of work.

    Args:
        name: what a folder of it holds.
        marks: patterns of files by one of which such a folder is known.
        leaves: patterns of all that it writes.
    """

    name: str
    marks: tuple[str, ...]
    leaves: tuple[str, ...]


TRAINING = WorkKind(
    "a training",
    ("run.json", "checkpoint*.npz"),
    ("run.json", "checkpoint*", "curves.csv", "*-seed*.json"),
)
STUDY = WorkKind(
    "a study",
    ("study.json", "records/*.record.npz"),
    ("study.json", "records", "damaged", "report.html"),
)
GENERALISATION = WorkKind(
    "a test of robustness",
    ("records/*.trial.npz",),
    ("records", "margins.csv", "left_out.csv", "curves.*"),
)
GAIT_MAP = WorkKind("a map of gaits", ("records/*.map.npz",), ("records",))
GAIT_FRONT = WorkKind("a front", ("records/*.front.npz",), ("records",))
KINDS = (TRAINING, STUDY, GENERALISATION, GAIT_MAP, GAIT_FRONT)


@contextmanager
def alone(folder: Path, work: WorkKind, *, restart: bool = False) -> Iterator[None]:
    """Lock a folder for this process alone, and make it if it is missing.

    Args:
        folder: where.
        work: of what kind.
        restart: whether what such work left there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: if the folder cannot be written, is in use, or is for another kind of work.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     (Path(folder) / "run.json").touch()
        ...     with alone(Path(folder), STUDY):
        ...         pass
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: ... holds a training, and is not for a study; ...
    """
    require_free_for(folder, work)
    with locked(output_folder(folder)):
        if restart:
            _set_aside(folder, work)
        yield


def require_free_for(folder: Path, work: WorkKind) -> None:
    """Raise `TegotaeError` if a folder holds another kind of work."""
    for kind in KINDS:
        if kind != work and any(any(folder.glob(mark)) for mark in kind.marks):
            raise TegotaeError(
                f"{folder} holds {kind.name}, and is not for {work.name}; choose another folder"
            )


def _set_aside(folder: Path, work: WorkKind) -> None:
    paths = [path for pattern in work.leaves for path in folder.glob(pattern)]
    if paths:
        place = output_folder(earlier(folder.resolve()))
        for path in dict.fromkeys(paths):
            move(path, place / path.name)
        print(f"the earlier content of {folder} is now in {place}")


def move(path: Path, place: Path) -> None:
    """Give a file or a folder another name.

    Raises:
        TegotaeError: if it cannot be moved.
    """
    try:
        os.replace(path, place)
    except OSError as error:
        raise TegotaeError(f"cannot move {path} to {place}: {error.strerror}") from None


def earlier(path: Path) -> Path:
    """Return a free name beside a file or a folder, for its earlier content.

    Example:
        >>> earlier(Path("nowhere/art")).as_posix()
        'nowhere/art.earlier1'
    """
    names = (path.with_name(f"{path.name}{_EARLIER}{number}") for number in count(1))
    return next(name for name in names if not name.exists())


def is_earlier(name: str) -> bool:
    """Return whether a folder of this name was archived, and is no part of the current content.

    Example:
        >>> is_earlier("art.earlier1"), is_earlier("art")
        (True, False)
    """
    stem, marked, number = name.rpartition(_EARLIER)
    return bool(stem and marked) and number.isdigit()
