"""One single-threaded XLA device per CPU core, or the GPUs where JAX has them."""

from __future__ import annotations

import os
import socket
from importlib.metadata import version
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from tegotae.errors import TegotaeError, require_count

_XLA_FLAGS = {
    # A rollout's tick is a few hundred elementwise operations with some twenty results. XLA fuses
    # such a graph once per result, and so computes it many times over, unless told to share.
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


def use_all_cores() -> None:
    """Ask XLA for one CPU device per core, for shared fusions and for loops as whole kernels.

    Called when `tegotae` is imported, and without effect once JAX has started its devices. The
    lanes of a rollout are shared out over devices: a device per core keeps every block of lanes in
    one core's cache. Flags that the user has set in `XLA_FLAGS` stand; `TEGOTAE_PLAIN_XLA=1` leaves
    everything as JAX has it.

    There are at least two devices, on one core too: XLA compiles a program for a single device in
    another way, and its results differ in their last bits.
    """
    if os.environ.get("TEGOTAE_PLAIN_XLA"):
        return
    flags = os.environ.get("XLA_FLAGS", "")
    wanted = dict(_XLA_FLAGS)
    if jaxlib_version() in _TESTED_JAXLIB:
        wanted["xla_backend_extra_options"] += "," + ",".join(_WHOLE_LOOPS)
        wanted |= _VECTORS | _PATIENCE
    missing = [f"--{name}={value}" for name, value in wanted.items() if name not in flags]
    os.environ["XLA_FLAGS"] = " ".join([*filter(None, [flags]), *missing])
    if "xla_force_host_platform_device_count" in flags:
        return
    try:
        jax.config.update("jax_num_cpu_devices", max(2, available_cores()))
    except RuntimeError:
        return  # JAX is running already: the devices it has are the ones we use


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

    The environment is read when `tegotae` is imported, which may be before a worker's is set. On
    one device, or without the options of `use_all_cores`, results differ in their last bits, which
    training magnifies.

    Raises:
        TegotaeError: if JAX is running already, with other devices or not as `tegotae` starts it.
    """
    try:
        if getattr(jax.config, "jax_num_cpu_devices", None) != count:
            jax.config.update("jax_num_cpu_devices", count)
    except RuntimeError:
        raise TegotaeError(
            f"the worker {socket.gethostname()} (process {os.getpid()}) has started JAX already, "
            f"with {described_devices()}; this work needs {count}: start the worker anew"
        ) from None


def described_devices() -> str:
    """Number and kind of the devices that lanes are shared out over, such as `2 cpu`."""
    devices = lane_devices()
    return f"{len(devices)} {devices[0].device_kind}"
