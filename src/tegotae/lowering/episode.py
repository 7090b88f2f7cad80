"""Episodes of many lanes as native code: a program of pure JAX functions, and the kernel of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tegotae.lowering.errors import CannotLower

Collect = Callable[[int, int, Any], None]
"""Takes the first lane of a group, how many it has, and its channels [frames, ..., lanes]."""


@dataclass(frozen=True)
class TracedEpisode:
    """A program of lanes, as pure JAX functions of one block: arrays [..., lanes], lanes last.

    The functions are traced once, for a single lane, and must be elementwise over lanes. A kernel
    is kept for every program that was compiled; a program is the same if its functions are equal,
    so that frozen dataclasses serve better than lambdas.

    Args:
        start: of (lanes, shared): the state at release.
        tick: of (lanes, shared, state, index): the state a control tick later.
        frame: of (lanes, shared, state, last index): at each frame's end the state for the next
            frame, and what is recorded.
    """

    start: Callable[[Any, Any], Any]
    tick: Callable[[Any, Any, Any, Any], Any]
    frame: Callable[[Any, Any, Any, Any], tuple[Any, Any]]


def compile_episode(
    episode: TracedEpisode,
    lanes_shapes: Any,
    shared_shapes: Any,
    dtype: str,
    *,
    target: str = "host",
    vectors: int = 2,
) -> Kernel:
    """The kernel of a program; the same one for the same program.

    Args:
        episode: the program.
        lanes_shapes: the pytree that `run` takes lane by lane, such as weights and scenario, as
            arrays or `jax.ShapeDtypeStruct` of shape [..., lanes]; how many lanes is ignored.
        shared_shapes: the pytree that all lanes share, of shape [...].
        dtype: "float32" or "float64".
        target: "host", "avx2", "avx512", "aarch64", or "scalar".
        vectors: vectors of lanes that a block has. Results do not depend on it.

    Raises:
        CannotLower: for an operation that has no native code, by its name and place.
    """
    raise CannotLower("episode")


@dataclass(frozen=True)
class Kernel:
    """A compiled program of lanes.

    A lane's results are the same bits whatever its neighbours, the vectors of a block, the
    processor, and the number of threads.
    """

    target: str
    """What it was compiled for."""
    block: int
    """Lanes that are advanced together; a last block is filled up with the last lane."""
    compile_seconds: float
    """Seconds that tracing and compiling took."""
    channels: Any
    """What a frame records, as `jax.ShapeDtypeStruct` of one lane."""

    def run(
        self,
        lanes: Any,
        shared: Any,
        *,
        frames: int,
        ticks_per_frame: int,
        threads: int | None = None,
        collect: Collect,
    ) -> None:
        """Roll out every lane.

        Args:
            lanes: arrays [..., lanes], of the structure that was compiled.
            shared: arrays [...] that all lanes share.
            frames: how many frames.
            ticks_per_frame: control ticks of each.
            threads: how many work at once; as many as there are cores by default.
            collect: is called once a group of blocks, from any of the threads: with the group's
                first lane, its number of lanes, and its channels as arrays [frames, ..., lanes],
                which are only valid meanwhile. What it raises, `run` raises.
        """
        raise CannotLower("episode")
