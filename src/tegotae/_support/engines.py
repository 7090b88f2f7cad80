"""Selection of the engine, native code or XLA, and of its cores or GPU."""

from __future__ import annotations

import os
import warnings
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import jax

from lanewise.machine import optimisation_level
from lanewise.nodes import LanewiseError
from tegotae._support import compiled
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.workers import CORES
from tegotae._support.xla_programs import use_kept_programs

use_kept_programs()

NATIVE = "native"
XLA = "xla"
_ON_GPU = "xla on a GPU"
VARIABLE = "TEGOTAE_ENGINE"
_TESTED_LLVMLITE = ("0.50",)
"""Versions of llvmlite that native code was tested with."""


class EngineWarning(UserWarning):
    """XLA runs what native code was expected to run."""


def check_engine() -> None:
    """Raise `TegotaeError` for a `TEGOTAE_ENGINE` that is no engine or cannot be had, or a
    `LANEWISE_OPT` that is no level."""
    setting = os.environ.get(VARIABLE, "")
    if setting not in ("", NATIVE, XLA):
        raise TegotaeError(f"{VARIABLE} is {setting!r}; it must be {NATIVE} or {XLA}")
    if setting == NATIVE and (missing := why_not_native()):
        raise TegotaeError(f"{VARIABLE} is {NATIVE}, and {missing}")
    try:
        optimisation_level()
    except LanewiseError as error:
        raise TegotaeError(str(error)) from None


def selected() -> str:
    """Return this process's engine: `TEGOTAE_ENGINE`, or else native code on a CPU where it can be.

    Warns once where XLA takes the place of native code on a CPU. On a GPU XLA is the engine.

    Raises:
        TegotaeError: as `check_engine`.
    """
    check_engine()
    setting = os.environ.get(VARIABLE, "")
    if setting == NATIVE:
        return NATIVE
    if jax.default_backend() != "cpu":
        return _ON_GPU
    if setting == XLA:
        return XLA
    missing = why_not_native()
    if missing:
        _say(f"{missing}; XLA runs instead, which is slower and has other last bits")
    return XLA if missing else NATIVE


def require_engine(engine: str, holder: str, remedy: str, ours: str = "") -> None:
    """Raise `TegotaeError` unless the engine that continues also made the existing results.

    Args:
        engine: the engine that made it: its name, and after a comma what it left to another one.
        holder: what is there, such as "FOLDER holds a training".
        remedy: what else would do than the other engine, such as "choose another folder".
        ours: the engine that would continue, named in the same way; this process's by default.
    """
    theirs, ours = engine.partition(",")[0], (ours or selected()).partition(",")[0]
    if theirs != ours:
        raise TegotaeError(
            f"{holder} of the engine {theirs}, and this is {ours}, whose numbers have other last "
            f"bits; set {VARIABLE}={theirs.partition(' ')[0]}, or {remedy}"
        )


@cache
def why_not_native() -> str:
    """Return the reason why native code is unavailable; empty if it is available."""
    try:
        installed = version("llvmlite")
    except PackageNotFoundError:
        return "llvmlite is not installed"
    if not installed.startswith(tuple(f"{tested}." for tested in _TESTED_LLVMLITE)):
        return (
            f"llvmlite is {installed}, and native code is tested with {', '.join(_TESTED_LLVMLITE)}"
        )
    return ""


@cache
def _say(message: str) -> None:
    """Warn of it, once."""
    warnings.warn(message, EngineWarning, stacklevel=4)


def available_cores() -> int:
    """Return the number of cores that this process may use; `TEGOTAE_CORES` sets fewer or more."""
    setting = os.environ.get(CORES, "")
    return int(setting) if _is_core_count(setting) else _own_cores()


def _own_cores() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS or Windows
        return os.cpu_count() or 1


def _most_cores() -> int:
    """Return the largest number of cores that can be requested; each has a thread and memory of its
    own.
    """
    return max(64, 4 * _own_cores())


def _is_core_count(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 9 and 1 <= int(text) <= _most_cores()


def require_workers(count: int, *, least: int = 1) -> None:
    """Raise `TegotaeError` unless this machine may have so many worker processes."""
    require_count("workers", count, least=least)
    if count > _most_cores():
        raise TegotaeError(
            f"workers is {count}; on this machine of {_own_cores()} cores it must be at most "
            f"{_most_cores()}"
        )


_SETTINGS = {
    "jax_enable_x64": "results are of 32 bits, and would be others",
    "jax_debug_nans": "NaN is a value here, of what is undefined",
    "jax_debug_infs": "infinity is a value here, of what has no limit",
}
"""Settings of JAX that must be off, with the reason."""


def check_jax() -> None:
    """Raise `TegotaeError` where a setting of JAX would change results, or end a command midway.

    Example:
        >>> with jax.enable_x64(True):
        ...     check_jax()
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: jax_enable_x64 is on, and ...
    """
    for name, reason in _SETTINGS.items():
        if getattr(jax.config, name):
            raise TegotaeError(
                f"{name} is on, and {reason}; unset {name.upper()}, or jax.config.update({name!r}, "
                "False)"
            )


def check_environment() -> None:
    """Check that the engine and cores that the environment names are available.

    Raises:
        TegotaeError: for a `TEGOTAE_CORES` that is no number or beyond sense, a `TEGOTAE_CACHE`
            that is no folder of its own, a `JAX_PLATFORMS` or `JAX_PLATFORM_NAME` that JAX cannot
            start, other settings of JAX (`check_jax`), or a `TEGOTAE_ENGINE` that cannot be had.
    """
    setting = os.environ.get(CORES, "")
    if setting and not _is_core_count(setting):
        raise TegotaeError(
            f"{CORES} is {setting!r}; on this machine of {_own_cores()} cores it must be a whole "
            f"number from 1 to {_most_cores()}"
        )
    compiled.check_code_folder()
    check_engine()
    check_jax()
    for variable in ("JAX_PLATFORMS", "JAX_PLATFORM_NAME"):
        platforms = os.environ.get(variable, "")
        if platforms not in ("", "cpu"):
            try:
                jax.local_devices()
            except (AssertionError, RuntimeError) as error:  # the former where it has no device
                reason = (str(error).splitlines() or ["there is no such device"])[0]
                raise TegotaeError(
                    f"{variable} is {platforms!r}, which JAX cannot start here: {reason}"
                ) from None
