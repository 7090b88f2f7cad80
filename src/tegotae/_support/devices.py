"""One single-threaded XLA device per CPU core, or the GPUs where JAX has them."""

from __future__ import annotations

import os
import socket
import warnings
from importlib.metadata import version
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from tegotae._support.compilation_cache import use_cache
from tegotae._support.errors import TegotaeError, require_count

_XLA_FLAGS = {
    # A rollout's tick is a few hundred elementwise operations with some twenty results. XLA fuses
    # such a graph once per result, and so computes it many times over, unless set to share.
    "xla_backend_extra_options": "xla_cpu_use_multi_output_fusion=true",
}

_VECTORS = {
    # Of use on AVX-512 machines, of no effect on others.
    "xla_cpu_prefer_vector_width": "512",
}

_WHOLE_LOOPS = (
    # A loop becomes one kernel if it touches fewer bytes than this: then the ticks of a frame need
    # the runtime once, not for each of the 45 small kernels of a tick.
    "xla_cpu_small_while_loop_byte_threshold=1000000",
    # The other emitter makes faster code of a tick.
    "xla_cpu_disable_tiled_emitter=true",
)

_USERS_FLAGS = os.environ.get("XLA_FLAGS", "")

_PATIENCE = {
    # Devices wait for each other. XLA takes a wait of 40 s for an error and ends the process, but
    # a training may be stopped with Ctrl-Z, or its laptop be closed.
    "xla_cpu_collective_call_warn_stuck_timeout_seconds": "604800",
    "xla_cpu_collective_call_terminate_timeout_seconds": "604800",
}

_TESTED_JAXLIB = ("0.10.2",)
"""Versions of jaxlib that know these; others, which may refuse to start, do without."""


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
    """The largest number that can be asked for: every device has threads and memory of its own."""
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
    """See that what the environment asks of the devices can be had.

    Raises:
        TegotaeError: for a `TEGOTAE_CORES` that is no number or beyond sense, or a `JAX_PLATFORMS`
            that JAX cannot start.
    """
    asked = os.environ.get(_CORES, "")
    if asked and not _is_core_count(asked):
        raise TegotaeError(
            f"{_CORES} is {asked!r}; on this machine of {_own_cores()} cores it must be a whole "
            f"number from 1 to {_most_cores()}"
        )
    platforms = os.environ.get("JAX_PLATFORMS", "")
    if platforms not in ("", "cpu"):
        try:
            jax.local_devices()
        except (AssertionError, RuntimeError) as error:  # the former where there is no such device
            why = (str(error).splitlines() or ["there is no such device"])[0]
            raise TegotaeError(
                f"JAX_PLATFORMS is {platforms!r}, which JAX cannot start here: {why}"
            ) from None


def jaxlib_version() -> str:
    """The version of jaxlib, which XLA comes with."""
    return version("jaxlib")


def set_up() -> None:
    """Set what the engine wants of JAX: a CPU device per core, options of XLA, kept programs.

    Called by the command line, by worker processes, and by whatever computes (rollouts, trainings,
    environments, checks), when it first does. Importing tegotae does not. It is of effect once, and
    only before JAX has started; a program that computes with JAX itself before it uses the engine
    calls it first. Where JAX has started otherwise, it stays as it is, and the first rollout warns
    (`JaxStartedWarning`): it may take several times as long, and differs in its last bits.

    The lanes of a rollout are shared out over devices: a device per core keeps every block of lanes
    in one core's cache. There are at least two, on one core too: XLA compiles a program for a
    single device in another way, and its results differ in their last bits. Flags that the user has
    set in `XLA_FLAGS` stand; `TEGOTAE_PLAIN_XLA=1` leaves XLA as JAX has it. Where compiled
    programs are kept, and how to have them elsewhere, is in `tegotae._support.compilation_cache`.
    """
    global _is_set_up
    if _is_set_up:
        return
    _is_set_up = True
    if _has_started():
        _warn_of_other_devices()
        return
    use_cache()
    if os.environ.get("TEGOTAE_PLAIN_XLA"):
        return
    flags = os.environ.get("XLA_FLAGS", "")
    missing = [f"--{name}={value}" for name, value in _wanted().items() if name not in flags]
    os.environ["XLA_FLAGS"] = " ".join([*filter(None, [flags]), *missing])
    if "xla_force_host_platform_device_count" not in flags:
        jax.config.update("jax_num_cpu_devices", max(2, available_cores()))


_is_set_up = False


class JaxStartedWarning(UserWarning):
    """JAX had started before the engine could set what it wants of it."""


def _has_started() -> bool:
    """Whether JAX has made its devices; from then on their number cannot be set."""
    before = jax.config.values["jax_num_cpu_devices"]
    try:
        jax.config.update("jax_num_cpu_devices", 2 if before != 2 else 3)
    except RuntimeError:
        return True
    jax.config.update("jax_num_cpu_devices", before)
    return False


def _warn_of_other_devices() -> None:
    if os.environ.get("TEGOTAE_PLAIN_XLA") or jax.local_devices()[0].platform != "cpu":
        return
    flags = os.environ.get("XLA_FLAGS", "")
    if len(jax.local_devices()) > 1 and all(name in flags for name in _wanted()):
        return
    warnings.warn(
        f"JAX was started before tegotae could set it up, on {len(jax.local_devices())} CPU "
        "device(s): rollouts may be slow, and differ in their last bits; call "
        "tegotae.set_up() before the first use of JAX",
        JaxStartedWarning,
        stacklevel=3,
    )


def _wanted() -> dict[str, str]:
    """The flags of XLA that are of use, by name."""
    wanted = dict(_XLA_FLAGS)
    if jaxlib_version() in _TESTED_JAXLIB:
        wanted["xla_backend_extra_options"] += "," + ",".join(_WHOLE_LOOPS)
        wanted |= _VECTORS | _PATIENCE
    return wanted


def xla_options() -> tuple[str, ...]:
    """The options of XLA that are on, as the environment has them: `name=value`."""
    options = []
    for flag in os.environ.get("XLA_FLAGS", "").split():
        name, _, value = flag.lstrip("-").partition("=")
        if name == "xla_backend_extra_options":
            options += value.split(",")
        else:
            options.append(f"{name}={value}" if value else name)
    return tuple(options)


def loops_are_kernels() -> bool:
    """Whether XLA makes one kernel of the loop over a frame's ticks."""
    return _WHOLE_LOOPS[0] in xla_options()


def environment(*, plain: bool = False) -> dict[str, str]:
    """Environment of a program to compare with: without `_WHOLE_LOOPS`, or with JAX as it comes.

    Flags that the user set stand in it, as they do here.
    """
    given = {**os.environ, "XLA_FLAGS": _USERS_FLAGS}
    if plain:
        return {**given, "TEGOTAE_PLAIN_XLA": "1"}
    others = _XLA_FLAGS | (_VECTORS if jaxlib_version() in _TESTED_JAXLIB else {})
    missing = [f"--{k}={v}" for k, v in others.items() if k not in _USERS_FLAGS]
    return {**given, "XLA_FLAGS": " ".join([_USERS_FLAGS, *missing]).strip()}


def lane_devices() -> list[Any]:
    """The devices that lanes are shared out over: all of JAX's default kind.

    Raises:
        TegotaeError: if the environment asks for what cannot be had.
    """
    set_up()
    check_environment()
    return jax.local_devices()


def on_cpu() -> bool:
    """Whether lanes are advanced on CPU cores."""
    return lane_devices()[0].platform == "cpu"


def on_every_device(tree: Any) -> Any:
    """The same arrays, inside a compiled program, whole on every device.

    What follows is then computed whole, too: a sum over lanes that are spread over devices would
    depend on their number in its last bits.
    """
    everywhere = NamedSharding(Mesh(np.array(lane_devices()), ("lanes",)), PartitionSpec())
    return jax.lax.with_sharding_constraint(tree, everywhere)


def compute_on(count: int) -> None:
    """Have this process compute on so many CPU devices, whatever its environment asks for.

    On one device, or without the options of `set_up`, results differ in their last bits, which
    training magnifies.

    Raises:
        TegotaeError: if JAX is running already, with other devices or not as `tegotae` starts it.
    """
    set_up()
    try:
        if jax.config.values["jax_num_cpu_devices"] != count:
            jax.config.update("jax_num_cpu_devices", count)
    except RuntimeError:
        raise TegotaeError(
            f"the worker {socket.gethostname()} (process {os.getpid()}) has started JAX already, "
            f"with {described_devices()}; this work needs {count}: start the worker anew, and call "
            "tegotae.set_up() before anything else there computes with JAX"
        ) from None


def described_devices() -> str:
    """Number and kind of the devices that lanes are shared out over, such as `2 cpu`."""
    devices = lane_devices()
    return f"{len(devices)} {devices[0].device_kind}"
