"""Unreasonable requests: refused before any work starts, with the memory that it would need."""

from __future__ import annotations

import os
from pathlib import Path

from tegotae._support.errors import TegotaeError, require_finite

MOST_RAD_PER_S = 1000.0
"""Frequencies ω: a radian per control tick of 1 ms; hoppers hop at about ten."""
MOST_N = 1e9
"""Forces."""
MOST_STEP_S = 3600.0
"""Time between two steps of a controller: float32 resolves a phase of so many radians."""
MOST_M = 1000.0
"""Heights, drops, and speeds in m/s, either way: float32 resolves 0.1 mm here."""
MOST_GAIN = 1e6
"""Gains σ [rad/(s N)]."""
MOST_POINTS = 2000
"""Points along an axis of a map, every one of which is a rollout."""
MOST_SEEDS = 100_000
"""Runs, readings or repetitions of one command."""
MOST_WEIGHTS = 1_000_000
"""Trained parameters of one controller."""


def require_within(name: str, value: float, most: float) -> None:
    """Raise `TegotaeError` unless `value` is finite and from -most to most.

    Example:
        >>> require_within("omega", 1e39, MOST_RAD_PER_S)
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: omega is 1e+39; it must be at most 1000
    """
    require_finite(name, value, least=-most, most=most)


def require_memory(n_bytes: float, subject: str) -> None:
    """Raise `TegotaeError` if this needs more memory than can be had.

    Args:
        n_bytes: how much, about.
        subject: what needs it: the first words of the sentence, such as "a map of 60 x 60 points".
    """
    available = available_memory()
    if available is not None and n_bytes > available:
        raise TegotaeError(
            f"{subject} would need about {_gib(n_bytes)} of memory, and {_gib(available)} are "
            "free; ask for less"
        )


def available_memory() -> float | None:
    """Return the memory that this process may still take [bytes], or None where the system does not
    say.

    That is the least of what the machine has left, and of what is left of the limits of a container
    (cgroup v2).
    """
    limits = [_machine_memory(), _container_memory()]
    return min((x for x in limits if x is not None), default=None)


def _machine_memory() -> float | None:
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024.0
    except (OSError, ValueError, IndexError):
        pass
    try:  # macOS says how much there is, not how much of it is left
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _container_memory() -> float | None:
    folder = Path("/sys/fs/cgroup")
    try:
        limit = float((folder / "memory.max").read_text())
        return max(0.0, limit - float((folder / "memory.current").read_text()) + _cache(folder))
    except (OSError, ValueError):  # none, or "max"
        return None


def _cache(folder: Path) -> float:
    """Return the file cache within the container's memory use, which the system frees on demand."""
    for line in (folder / "memory.stat").read_text().splitlines():
        name, _, value = line.partition(" ")
        if name == "file":
            return float(value)
    return 0.0


def _gib(n_bytes: float) -> str:
    return f"{n_bytes / 2**30:.3g} GiB"
