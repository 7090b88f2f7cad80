"""Files that are whole or not there; NumPy archives without pickle, bounded, with checksums."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import io
import os
import secrets
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from tegotae._support.errors import TegotaeError

msvcrt: Any = None
try:
    import fcntl
except ImportError:  # Windows
    fcntl = None
    msvcrt = import_module("msvcrt")

_LONGEST_NAME = 255
"""Longest file name that file systems take [bytes]."""


def require_short(place: Path | str) -> None:
    """Raise `TegotaeError` for a place with a name in it that no file can have."""
    name = max(Path(place).parts, key=_bytes, default="")
    if _bytes(name) > _LONGEST_NAME:
        raise TegotaeError(
            f"{name[:40]}... has {_bytes(name)} bytes; the name of a file has "
            f"{_LONGEST_NAME} at most"
        )


def _bytes(name: str) -> int:
    return len(os.fsencode(name))


def write_atomically(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a whole file beside `path`, then put it in its place in one step; make its folder.

    What a process left that was killed meanwhile is removed.

    Args:
        path: the file.
        content: all of it.
        mode: its permissions, less what the user's umask takes away.

    Raises:
        TegotaeError: if it cannot be written (no permission, no space left).
    """
    # Halves of characters, which a file's name can have, are in no encoding: they are spelled out.
    text = isinstance(content, str)
    data = content.encode(errors="backslashreplace") if text else content
    temporary = path
    try:
        if not path.parent.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(path)
        temporary, stream = _temporary(path, mode)
        with stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
            if fcntl is None:
                stream.close()  # as Windows asks for, where it is not locked
            temporary.replace(path)
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror}") from None
    finally:
        if temporary != path:
            with contextlib.suppress(OSError):
                temporary.unlink()


_RANDOM_BYTES = 4
"""Random bytes in a temporary file's name."""
_BINARY = getattr(os, "O_BINARY", 0)
"""A flag of Windows, which else changes the ends of lines."""


def _hidden(path: Path) -> str:
    """Return the beginning of the names of temporary files of `path`, short enough for their
    endings.
    """
    room = _LONGEST_NAME - len("..") - 2 * _RANDOM_BYTES
    return f".{os.fsdecode(os.fsencode(path.name)[:room])}."


def _temporary(path: Path, mode: int) -> tuple[Path, BinaryIO]:
    """Open a new file beside `path`, locked for as long as it is open."""
    while True:
        place = path.with_name(_hidden(path) + secrets.token_hex(_RANDOM_BYTES))
        number = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, mode)
        stream = os.fdopen(number, "wb")
        with contextlib.suppress(BlockingIOError):
            hold(stream.fileno())
            if place.exists():  # else another process has just taken it for abandoned
                return place, stream
        stream.close()


def _remove_abandoned(path: Path) -> None:
    """Remove temporary files of `path` whose writers have ended without doing so."""
    for place in path.parent.glob(glob.escape(_hidden(path)) + "[0-9a-f]" * 2 * _RANDOM_BYTES):
        with contextlib.suppress(OSError), place.open("rb") as stream:
            if hold(stream.fileno()):
                if fcntl is None:
                    stream.close()  # as Windows asks for
                place.unlink()


def hold(file: int) -> bool:
    """Lock an open file until it is closed; False where the file system has no locks.

    Args:
        file: its descriptor.

    Raises:
        BlockingIOError: if another process holds it.
    """
    try:
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            _lock_byte(file)
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True


_LOCKED_BYTE = 2**30
"""Place of the byte that Windows locks: behind all content, since no other may read it."""


def _lock_byte(file: int) -> None:
    place = os.lseek(file, 0, os.SEEK_CUR)
    try:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
    except PermissionError:  # another process has it
        raise BlockingIOError from None
    finally:
        os.lseek(file, place, os.SEEK_SET)


def output_folder(path: Path) -> Path:
    """Return the folder, made if it is missing and tested for writing.

    Raises:
        TegotaeError: if it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except FileExistsError:
        raise TegotaeError(f"cannot write to the folder {path}: it is a file") from None
    except OSError as error:
        raise TegotaeError(f"cannot write to the folder {path}: {error.strerror}") from None
    return path


def check_folder(path: Path) -> Path:
    """Test a folder for writing and return it; a missing folder is not left behind.

    For commands that check first and write at their end: what they refuse leaves nothing.

    Raises:
        TegotaeError: if it cannot be made or written to.
    """
    missing = [folder for folder in (path, *path.parents) if not os.path.lexists(folder)]
    try:
        return output_folder(path)
    finally:
        for folder in missing:
            with contextlib.suppress(OSError):  # never made, or used by now
                folder.rmdir()


def output_file(path: Path) -> Path:
    """Return the file's path after a test of its folder for writing; nothing is made.

    Raises:
        TegotaeError: if the folder cannot be written to, the path is a folder itself, or its name
            is too long.
    """
    require_short(path)
    check_folder(path.parent)
    if path.is_dir():
        raise TegotaeError(f"cannot write {path}: it is a folder")
    return path


def read_arrays(
    file: Path | BinaryIO, most_bytes: int, names: Iterable[str] | None = None
) -> dict[str, np.ndarray]:
    """Return the arrays of an archive by name.

    A few kilobytes can unpack to gigabytes, so the archive's directory is asked first.

    Args:
        file: its path, or the open file.
        most_bytes: of all arrays together.
        names: of those that are read; all by default.

    Raises:
        ValueError: if it is larger than that, no archive, or damaged.
        OSError: if it cannot be read, such as without permission.

    Example:
        >>> import io
        >>> stream = io.BytesIO()
        >>> np.savez_compressed(stream, zeros=np.zeros(1_000_000))
        >>> len(stream.getvalue()) < 10_000
        True
        >>> read_arrays(stream, 2**20)
        Traceback (most recent call last):
        ...
        ValueError: it unpacks to 7.63 MiB, more than 1 MiB
    """
    try:
        return _read(file, most_bytes, names)
    except OSError as error:
        if error.strerror:  # the system's, not that of a reader who met no archive
            raise
        raise ValueError(str(error)) from None
    except Exception as error:  # a flipped bit in a zip archive may raise nearly anything
        raise ValueError(str(error) or type(error).__name__) from None


def require_small(members: Iterable[zipfile.ZipInfo], most_bytes: int) -> None:
    """Raise `ValueError` if members of an archive unpack to more, all together.

    Nothing is unpacked, and of none more than this is read: its size in the directory ends it.
    """
    unpacked = sum(member.file_size for member in members)
    if unpacked > most_bytes:
        raise ValueError(
            f"it unpacks to {unpacked / 2**20:.3g} MiB, more than {most_bytes / 2**20:.3g} MiB"
        )


def checksum(text: str, arrays: dict[str, np.ndarray]) -> str:
    """Return a hash of a text and of arrays with their names, types and shapes."""
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {values.dtype.str} {values.shape}".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


def with_checksum(header: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return arrays with a `header`, and a `checksum` over all of it."""
    noted = checksum(header, dict(arrays))
    return {"header": np.array(header), "checksum": np.array(noted), **arrays}


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write an archive, whole or not at all.

    Args:
        path: its file.
        arrays: of numbers or text, by name.

    Raises:
        TegotaeError: if it cannot be written, such as for want of space.
    """
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)
    write_atomically(path, stream.getvalue())


def _read(
    file: Path | BinaryIO, most_bytes: int, names: Iterable[str] | None
) -> dict[str, np.ndarray]:
    with zipfile.ZipFile(file) as archive:
        require_small(archive.infolist(), most_bytes)
    if not isinstance(file, Path):
        file.seek(0)
    with np.load(file, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in (stored.files if names is None else names)}
    for name, values in arrays.items():
        if not isinstance(values, np.ndarray):
            raise ValueError(f"its entry {name!r} is no array")
    return arrays
