"""Compiled code that is kept between processes: a folder of this user's alone."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import stat
import sys
from functools import cache
from pathlib import Path

from tegotae._support.errors import TegotaeError

VARIABLE = "TEGOTAE_CACHE"
"""Names another folder; `off` keeps nothing."""
JAX_VARIABLE = "JAX_COMPILATION_CACHE_DIR"
"""Names the folder of JAX's programs."""
_MOST_FILES = 1000
_CHECKSUM_BYTES = hashlib.sha256().digest_size
_MARKER = "CACHEDIR.TAG"
_MARK = """Signature: 8a477f597d28d172789f06886806bc55
# Compiled code of tegotae, which makes it again if it is removed. See https://bford.info/cachedir/
"""
_KEPT = re.compile(r"\.?[0-9a-f]{64}\.o(\.[0-9a-f]+)?")
"""The name of a file of compiled code, or of one that was being written."""
_OF_JAX = re.compile(r"xla(-[0-9a-f]{16})?")
"""The name of a folder of programs that JAX itself kept there."""
_FORMAT = "2"
"""Version of the files; another one has other keys."""
_OF_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def folder() -> Path | None:
    """Return the folder of compiled code, made if it is missing; None where there must be none.

    Code from there is run, so nobody else may be able to write to it, and files are removed there,
    so it is marked, and has no other program's files when it is first used.

    Example:
        >>> os.environ[VARIABLE] = "off"
        >>> folder() is None
        True
    """
    setting = os.environ.get(VARIABLE, "")
    if setting == "off":
        return None
    with contextlib.suppress(OSError, RuntimeError):  # no permission, no space, no home
        place = Path(setting) if setting else _default_folder()
        if place is not None and not _create(place):
            return place
    return None


def check_code_folder() -> None:
    """Raise `TegotaeError` for a `TEGOTAE_CACHE` that has other files, or others can change."""
    setting = os.environ.get(VARIABLE, "")
    if setting in ("", "off"):
        return
    with contextlib.suppress(OSError):  # where nothing can be kept, nothing is
        if problem := _create(Path(setting)):
            raise TegotaeError(
                f"TEGOTAE_CACHE is {setting!r}, {problem}; name a new folder, or off"
            )


def _create(place: Path) -> str:
    """Make and mark a folder; return the reason why it must not be used, or nothing."""
    place.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not _is_of_user(place.stat()):
        return "which others can write to"
    if _content(place / _MARKER) == _MARK.encode():
        return ""
    for entry in os.scandir(place):
        ours = any(
            pattern.fullmatch(entry.name) for pattern in (_KEPT, _OF_JAX, re.compile(_MARKER))
        )
        if not ours or not _is_of_user(entry.stat(follow_symlinks=False)):
            return f"which has a file of another program or user, {entry.name!r}"
    (place / _MARKER).write_text(_MARK)
    return ""


def _is_of_user(status: os.stat_result) -> bool:
    """Return True if a file or folder is this user's alone: no other can change it or has linked
    it."""
    if not hasattr(os, "getuid"):
        return True
    linked = stat.S_ISLNK(status.st_mode) or (stat.S_ISREG(status.st_mode) and status.st_nlink > 1)
    return status.st_uid == os.getuid() and not status.st_mode & _OF_OTHERS and not linked


def _content(path: Path) -> bytes | None:
    """Return the bytes of a plain file of this user, or None for any other."""
    try:
        with open(path, "rb", opener=_opened) as file:
            status = os.fstat(file.fileno())
            return file.read() if stat.S_ISREG(status.st_mode) and _is_of_user(status) else None
    except OSError:
        return None


def _opened(name: str, flags: int) -> int:
    """Open a file and return its descriptor; links are refused, and a pipe without a writer does
    not block.
    """
    return os.open(name, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))


def _default_folder() -> Path | None:
    """Return the default folder, or None for a user without a home."""
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME"
    path = Path(os.environ.get(variable, ""))
    if sys.platform != "darwin" and path.is_absolute():
        return path / "tegotae"
    home = Path.home()
    if home == Path(home.anchor):  # an empty HOME
        return None
    return home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "tegotae"


def key_of(*parts: str) -> str:
    """Return the name under which code is kept: a hash of everything that determines it.

    Args:
        parts: source, processor, options, version of the compiler.
    """
    return hashlib.sha256("\0".join((_FORMAT, *parts)).encode()).hexdigest()


def stored_code(key: str) -> bytes | None:
    """Return the code kept under a key, or None if there is none, or if it is damaged.

    Args:
        key: as `key_of` makes it.
    """
    place = folder()
    if place is None:
        return None
    path = place / f"{key}.o"
    sealed_code = _content(path) or b""
    checksum, content = sealed_code[:_CHECKSUM_BYTES], sealed_code[_CHECKSUM_BYTES:]
    if _checksum(key, content) != checksum:
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # what was used last is removed last
    return content


def _checksum(key: str, content: bytes) -> bytes:
    """Return a hash of code and its key, so that no file passes under another one's name."""
    return hashlib.sha256(key.encode() + content).digest()


def store_code(key: str, content: bytes) -> None:
    """Keep code under a key; if that is impossible, keep nothing.

    Args:
        key: as `key_of` makes it.
        content: the code.
    """
    from tegotae._support.files import write_atomically  # of NumPy, which help does without

    place = folder()
    if place is None:
        return
    with contextlib.suppress(OSError, TegotaeError):
        write_atomically(place / f"{key}.o", _checksum(key, content) + content, mode=0o600)
        _remove_oldest(place)


def _remove_oldest(place: Path) -> None:
    files = [path for path in place.iterdir() if _KEPT.fullmatch(path.name)]
    files.sort(key=lambda path: path.lstat().st_mtime)
    for path in files[:-_MOST_FILES]:
        path.unlink(missing_ok=True)


def keep_xla_programs() -> None:
    """Let JAX keep its programs there, too, unless it has a folder already; before it is imported.

    It is a setting of the whole process, for programs of ours alone. JAX's own files can be cut
    short by two processes, and are not checked: `tegotae._support.xla_programs` keeps them.
    """
    place = folder()
    if place is None or JAX_VARIABLE in os.environ:
        return
    os.environ[JAX_VARIABLE] = xla_folder(place)
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    os.environ["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "-1"


def xla_folder(place: Path | None) -> str:
    """Return JAX's cache folder; it is never made while its programs are kept for it."""
    return "" if place is None else str(place / "xla")


def key_of_xla_program(key: str) -> str:
    """Return the name under which a program of JAX is kept; JAX's own key does not name the
    processor.
    """
    return key_of(key, platform.machine(), *_processor())


@cache
def _processor() -> list[str]:
    """Return Linux's description of the first processor; elsewhere its name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
    except OSError:
        return [platform.processor()]
    return [line for line in lines if line.startswith(("model name", "flags", "Features"))]
