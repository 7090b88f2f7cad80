"""Compiled code that is kept between processes: a folder of this user's alone."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import stat
import sys
from pathlib import Path

from tegotae._support.errors import TegotaeError

VARIABLE = "TEGOTAE_CACHE"
"""Names another folder; `off` keeps nothing."""
_MOST_FILES = 1000
_CHECKSUM_BYTES = hashlib.sha256().digest_size


def folder() -> Path | None:
    """Where compiled code is kept, made if it is missing; None where it must not be.

    Code from there is run, so nobody else may be able to write to it.

    Example:
        >>> os.environ[VARIABLE] = "off"
        >>> folder() is None
        True
    """
    asked = os.environ.get(VARIABLE, "")
    if asked == "off":
        return None
    try:
        place = Path(asked) if asked else _of_user() / "tegotae"
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = place.stat()
    except (OSError, RuntimeError):  # no permission, no space, no home
        return None
    ours = not hasattr(os, "getuid") or (
        found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    )
    return place if ours else None


def _of_user() -> Path:
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME"
    given = os.environ.get(variable, "")
    return Path(given) if given else Path.home() / ".cache"


def key_of(*parts: str) -> str:
    """The name under which code is kept: a hash of all that it is made of.

    Args:
        parts: source, processor, options, version of the compiler.
    """
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def kept(key: str) -> bytes | None:
    """Code that was kept under a key; None if there is none, or if it is damaged.

    Args:
        key: as `key_of` makes it.
    """
    place = folder()
    if place is None:
        return None
    try:
        whole = (place / f"{key}.o").read_bytes()
    except OSError:
        return None
    checksum, content = whole[:_CHECKSUM_BYTES], whole[_CHECKSUM_BYTES:]
    return content if hashlib.sha256(content).digest() == checksum else None


def keep(key: str, content: bytes) -> None:
    """Keep code under a key; where that is not possible, nothing is kept.

    Args:
        key: as `key_of` makes it.
        content: the code.
    """
    from tegotae._support.files import write_atomically  # of NumPy, which help does without

    place = folder()
    if place is None:
        return
    with contextlib.suppress(OSError, TegotaeError):
        write_atomically(place / f"{key}.o", hashlib.sha256(content).digest() + content)
        _remove_oldest(place)


def _remove_oldest(place: Path) -> None:
    files = [path for path in place.rglob("*") if path.is_file()]
    files.sort(key=lambda path: path.stat().st_mtime)
    for path in files[:-_MOST_FILES]:
        path.unlink(missing_ok=True)


def keep_xla_programs() -> None:
    """Let JAX keep its programs there, too, unless it has a folder already; before it is imported.

    It is a setting of the whole process, for programs of ours alone.
    """
    place = folder()
    if place is None or "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    # Its own key does not name the processor.
    processor = key_of(platform.machine(), *_processor())[:16]
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(place / f"xla-{processor}")
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    os.environ["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "-1"


def forget_xla_programs() -> bool:
    """Remove the programs that JAX kept here, one of which is damaged; False if it keeps none here.

    A process that is killed leaves half a file, and JAX never writes another in its place.
    """
    place, ours = Path(os.environ.get("JAX_COMPILATION_CACHE_DIR", "")), folder()
    if ours is None or place.parent != ours:
        return False
    for file in place.glob("*"):
        with contextlib.suppress(OSError):
            file.unlink()
    return True


def _processor() -> list[str]:
    """Return Linux's description of the first processor; elsewhere its name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
    except OSError:
        return [platform.processor()]
    return [line for line in lines if line.startswith(("model name", "flags", "Features"))]
