"""Cores, and what the environment asks of them."""

from __future__ import annotations

import os

import jax

from tegotae._support.engines import check_engine
from tegotae._support.errors import TegotaeError, require_count

_CORES = "TEGOTAE_CORES"


def available_cores() -> int:
    """Cores that this process may use; `TEGOTAE_CORES` asks for fewer or more."""
    asked = os.environ.get(_CORES, "")
    return int(asked) if _is_core_count(asked) else _own_cores()


def _own_cores() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS or Windows
        return os.cpu_count() or 1


def _most_cores() -> int:
    """The largest number that can be asked for: every core has a thread and memory of its own."""
    return max(64, 4 * _own_cores())


def _is_core_count(asked: str) -> bool:
    return (
        asked.isascii() and asked.isdigit() and len(asked) < 9 and 1 <= int(asked) <= _most_cores()
    )


def require_workers(count: int) -> None:
    """Raise `TegotaeError` unless this machine may have so many worker processes."""
    require_count("workers", count)
    if count > _most_cores():
        raise TegotaeError(
            f"workers is {count}; on this machine of {_own_cores()} cores it must be at most "
            f"{_most_cores()}"
        )


def check_environment() -> None:
    """See that what the environment asks for can be had.

    Raises:
        TegotaeError: for a `TEGOTAE_CORES` that is no number or beyond sense, a `JAX_PLATFORMS`
            that JAX cannot start, or a `TEGOTAE_ENGINE` that cannot be had.
    """
    asked = os.environ.get(_CORES, "")
    if asked and not _is_core_count(asked):
        raise TegotaeError(
            f"{_CORES} is {asked!r}; on this machine of {_own_cores()} cores it must be a whole "
            f"number from 1 to {_most_cores()}"
        )
    check_engine()
    platforms = os.environ.get("JAX_PLATFORMS", "")
    if platforms not in ("", "cpu"):
        try:
            jax.local_devices()
        except (AssertionError, RuntimeError) as error:  # the former where there is no such device
            why = (str(error).splitlines() or ["there is no such device"])[0]
            raise TegotaeError(
                f"JAX_PLATFORMS is {platforms!r}, which JAX cannot start here: {why}"
            ) from None
