"""Writing files so that a crash, a full disk or a kill never leaves half a file."""

from __future__ import annotations

import contextlib
import os
import secrets
import tempfile
from pathlib import Path

from tegotae._support.errors import TegotaeError


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a whole file beside `path`, then put it in its place in one step; make its folder.

    Raises:
        TegotaeError: if it cannot be written (no permission, no space left).
    """
    # Halves of characters, which a file's name can have, are in no encoding: they are spelled out.
    text = isinstance(content, str)
    data = content.encode(errors="backslashreplace") if text else content
    # Opened like any new file, so that it gets the permissions that the user's umask asks for.
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        if not path.parent.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("xb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def output_folder(path: Path) -> Path:
    """The folder, made if it is missing and tried for writing.

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
    """The folder, tried for writing; no folder is left that was missing.

    For commands that check first and write at their end: what they refuse leaves nothing.

    Raises:
        TegotaeError: if it cannot be made or written to.
    """
    missing = [each for each in (path, *path.parents) if not os.path.lexists(each)]
    try:
        return output_folder(path)
    finally:
        for each in missing:
            with contextlib.suppress(OSError):  # never made, or used by now
                each.rmdir()


def output_file(path: Path) -> Path:
    """The file's path, its folder tried for writing; nothing is made.

    Raises:
        TegotaeError: if the folder cannot be written to, or the path is a folder itself.
    """
    check_folder(path.parent)
    if path.is_dir():
        raise TegotaeError(f"cannot write {path}: it is a folder")
    return path
