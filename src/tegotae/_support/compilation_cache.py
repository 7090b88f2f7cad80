"""Compiled programs kept between runs, in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import tempfile
import warnings
from pathlib import Path

import jax

LARGEST_BYTES = 2**30
"""Size of the cache [bytes] from which on the programs used least recently are dropped."""


def use_cache() -> Path | None:
    """Let JAX keep what it compiles, and return the folder; None if nothing is kept by this.

    Called by `tegotae._support.devices.set_up`. `TEGOTAE_CACHE=off` keeps nothing, any other value
    is the folder to use. Where the user has set JAX's own (`JAX_COMPILATION_CACHE_DIR`), that
    stands. A folder that cannot be written to is no error: programs are then compiled anew.

    Programs are safe among processes that run at a time: JAX takes a lock. They hold machine code,
    so every kind of processor has a folder of its own.
    """
    asked = os.environ.get("TEGOTAE_CACHE", "")
    if asked.lower() == "off" or jax.config.values.get("jax_compilation_cache_dir"):
        return None
    folder = (Path(asked).expanduser() if asked else user_folder()) / _processor()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, RuntimeError):  # the latter: no home to expand
        return None
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_compilation_cache_max_size", LARGEST_BYTES)
    # Everything: a command runs dozens of programs that take a tenth of a second each.
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    # A folder that fills up or an entry cut short by a killed process costs time, and no more.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation")
    return folder


def user_folder() -> Path:
    """Where this user's programs keep what can be made anew, by the custom of the system."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "tegotae" / "programs"


def _processor() -> str:
    """A short name for what this machine's processor can do."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        features = next(line for line in lines if line.startswith(("flags", "Features")))
    except (OSError, StopIteration):
        features = platform.processor()
    return hashlib.sha256(f"{platform.machine()} {features}".encode()).hexdigest()[:12]
