"""Episodes of many lanes as native code: a program of pure JAX functions, and the kernel of it."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import jax
import numpy as np

from lanewise.machine import Code, Store, Target, target_of
from lanewise.module import EpisodeModule, RecordedArrays, Rows, aligned
from lanewise.native_reader import NativeReader, given_arrays
from lanewise.nodes import LANE, TICK, UNIFORM, Node, Tree, scalars
from lanewise.placement import Stages

_BUFFER_BYTES = 4 * 2**20
"""Frames that a thread records before they are collected, unless a block alone has more."""

_GROUPS_OF_THREAD = 4
"""Groups that a thread has at least, where there are so many lanes."""
_LANES_TOGETHER = 64
"""Lanes of a group, or a multiple of them: so many are summarised at a time."""

Collect = Callable[[int, int, Tree], None]
"""Takes the first lane of a group, how many it has, and its channels [frames, ..., lanes], the last
lane's again behind them until there are as many as in every group."""


@dataclass(frozen=True)
class TracedEpisode:
    """A program of lanes, as pure JAX functions of one block: arrays [..., lanes], lanes last.

    The functions are traced once, for a single lane, and must be elementwise over lanes.

    Args:
        start: of (lanes, shared): the state at release.
        tick: of (lanes, shared, state, index): the state a control tick later.
        frame: of (lanes, shared, state, last index): at each frame's end the state for the next
            frame, and what is recorded.
    """

    start: Callable[[Tree, Tree], Tree]
    tick: Callable[[Tree, Tree, Tree, jax.Array], Tree]
    frame: Callable[[Tree, Tree, Tree, jax.Array], tuple[Tree, Tree]]


def compile_episode(
    episode: TracedEpisode,
    lanes_shapes: Tree,
    shared_shapes: Tree,
    dtype: str,
    *,
    target: str | Target = "host",
    vectors: int = 2,
    store: Store | None = None,
) -> Kernel:
    """Trace, read and compile the kernel of a program.

    Args:
        episode: the program.
        lanes_shapes: the pytree that `run` takes lane by lane, such as weights and scenario, as
            arrays or `jax.ShapeDtypeStruct` of shape [..., lanes]; how many lanes is ignored.
        shared_shapes: the pytree that all lanes share, of shape [...].
        dtype: "float32" or "float64".
        target: "host", "avx2", "avx512", "aarch64", "scalar", or a `Target`.
        vectors: vectors of lanes that a block has. Results do not depend on it.
        store: where machine code is kept; nowhere if None.

    Raises:
        CannotLower: for an operation that has no native code, by its name and place.
    """
    machine = target_of(target)
    with jax.enable_x64(dtype == "float64"):
        lanes = jax.tree.map(_one_lane, lanes_shapes)
        shared = jax.tree.map(_shape, shared_shapes)
        stages, channels = _read(episode, lanes, shared)
    recorded = _recorded(stages.channels, jax.tree.leaves(channels))
    module = EpisodeModule(stages, _kinds(lanes), recorded, machine, dtype, vectors)
    return Kernel(
        channels, module, _kinds(shared), Code.compiled(module.text(), machine, store=store)
    )


def _shape(x: jax.Array | jax.ShapeDtypeStruct) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(x.shape, x.dtype)


def _one_lane(x: jax.Array | jax.ShapeDtypeStruct) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct((*x.shape[:-1], 1), x.dtype)


def _kinds(tree: Tree) -> tuple[str, ...]:
    return tuple(node.kind for node in scalars(given_arrays("", tree)))


def _recorded(nodes: Sequence[Node], leaves: Sequence[jax.ShapeDtypeStruct]) -> RecordedArrays:
    """Return the arrays that channels record, with the kinds of their scalars."""
    scalars = tuple(math.prod(leaf.shape) for leaf in leaves)
    lasts = itertools.accumulate(scalars)
    kinds = tuple(
        nodes[last - 1].kind if count else "float32"
        for count, last in zip(scalars, lasts, strict=True)
    )
    return RecordedArrays(kinds, scalars)


_STAGES = {"shared": UNIFORM, "lanes": LANE, "state": TICK, "index": TICK}


def _read(episode: TracedEpisode, lanes: Tree, shared: Tree) -> tuple[Stages, Tree]:
    """Trace a program for one lane; return it with the shapes that a frame records."""
    reader = NativeReader()

    def read(function: Callable[..., Tree], **inputs: Tree) -> tuple[list[Node], Tree]:
        trace, shapes = jax.make_jaxpr(function, return_shape=True)(*inputs.values())
        arrays = [
            array
            for name, tree in inputs.items()
            for array in given_arrays(name, tree, _STAGES[name])
        ]
        return scalars(reader.read(trace, arrays)), shapes

    start, state = read(episode.start, lanes=lanes, shared=shared)
    index = jax.ShapeDtypeStruct((), "int32")
    inputs = {"lanes": lanes, "shared": shared, "state": jax.tree.map(_shape, state)}
    tick, _ = read(episode.tick, **inputs, index=index)
    frame, (_, channels) = read(episode.frame, **inputs, index=index)
    return Stages(start, tick, frame[: len(start)], frame[len(start) :]), channels


@dataclass(frozen=True)
class Kernel:
    """A compiled program of lanes.

    A lane's results are the same bits whatever its neighbours, the vectors of a block, the
    processor, and the number of threads.
    """

    channels: Tree
    """Channels of a frame, as `jax.ShapeDtypeStruct` of one lane."""
    module: EpisodeModule = field(repr=False)
    shared_kinds: tuple[str, ...] = field(repr=False)
    """Types in C of what all lanes share, number by number."""
    code: Code = field(repr=False)

    def run(
        self,
        lanes: Tree,
        shared: Tree,
        *,
        frames: int,
        ticks_per_frame: int,
        threads: int = 1,
        collect: Collect,
    ) -> None:
        """Roll out every lane; a last block is filled up with the last lane.

        Args:
            lanes: arrays [..., lanes], of the structure that was compiled.
            shared: arrays [...] that all lanes share.
            frames: how many frames.
            ticks_per_frame: control ticks of each.
            threads: how many work at once.
            collect: is called once a group of blocks, from any of the threads, with what `Collect`
                says; the channels are only valid meanwhile. What it raises, `run` raises.
        """
        leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(lanes)]
        count = leaves[0].shape[-1]
        rows = [leaf.reshape(-1, count) for leaf in leaves]
        blocks = -(-count // self.module.block)
        threads = max(1, min(threads, blocks))
        group = self._blocks_of_group(blocks, threads, frames)
        run = _Run(self, rows, self._uniform(shared), frames, ticks_per_frame, group, collect)
        firsts, lock = iter(range(0, blocks, group)), threading.Lock()

        def next_first() -> int | None:
            with lock:
                return next(firsts, None)

        if threads == 1:
            run.work(next_first)
            return
        with ThreadPoolExecutor(threads) as pool:
            for future in [pool.submit(run.work, next_first) for _ in range(threads)]:
                future.result()

    def _uniform(self, shared: Tree) -> np.ndarray:
        """Compute the values that all lanes share, once."""
        memory = aligned(8 * len(self.shared_kinds))
        uniform = aligned(self.module.uniform_bytes)
        numbers = [x for leaf in jax.tree.leaves(shared) for x in np.asarray(leaf).reshape(-1)]
        for i, (number, dtype) in enumerate(
            zip(numbers, Rows(self.shared_kinds).dtypes, strict=True)
        ):
            np.ndarray((1,), dtype, memory.data, 8 * i)[0] = number
        self.code.function("uniform", 2)(memory.ctypes.data, uniform.ctypes.data)
        return uniform

    def _blocks_of_group(self, blocks: int, threads: int, frames: int) -> int:
        """Return the blocks per group: as many as the buffer holds, few enough that no thread waits
        long."""
        block = self.module.block
        frame_bytes = self.module.recorded.size * block * frames
        fits = max(1, _BUFFER_BYTES // max(1, frame_bytes))
        together = max(1, _LANES_TOGETHER // block)
        shares = -(-blocks // (_GROUPS_OF_THREAD * threads * together)) * together
        return min(fits, shares)


@dataclass(frozen=True)
class _Run:
    """One run of a kernel: the state that all threads share."""

    kernel: Kernel
    rows: Sequence[np.ndarray]
    """Inputs of each lane, [rows, lanes], leaf by leaf."""
    uniform: np.ndarray
    frames: int
    ticks: int
    group: int
    """Blocks that are collected at a time."""
    collect: Collect

    def work(self, next_first: Callable[[], int | None]) -> None:
        """Roll out group after group, by their first blocks, in memory of this thread's own."""
        module, code, lanes = self.kernel.module, self.kernel.code, self.rows[0].shape[-1]
        block, row = module.block, module.block * self.group
        tables = (module.lane_rows, module.invariant_rows, module.state_rows)
        inputs, invariant, state = (rows.memory(block) for rows in tables)
        out = module.recorded.memory(self.frames, row)
        start, episode = code.function("start", 4), code.function("episode", 5, 4)
        pointers = [memory.ctypes.data for memory in (inputs, self.uniform, invariant, state, out)]
        ends = itertools.accumulate(len(leaf) for leaf in self.rows)
        leaves = [
            module.lane_rows.view(inputs, end - len(leaf), end, block)
            for leaf, end in zip(self.rows, ends, strict=True)
        ]
        while (first := next_first()) is not None:
            ahead = lanes - first * block
            blocks = min(self.group, -(-ahead // block))
            for number in range(blocks):
                lane = (first + number) * block
                held = min(block, lanes - lane)
                for leaf, rows in zip(self.rows, leaves, strict=True):
                    rows[:, :held] = leaf[:, lane : lane + held]
                    rows[:, held:] = leaf[:, -1:]
                start(*pointers[:-1])
                episode(*pointers, self.frames, self.ticks, row, number * block)
            collected = min(blocks * block, ahead)
            arrays = module.recorded.views(out, self.frames, row)
            for array in arrays:  # a block has filled itself up
                array[..., blocks * block :] = array[..., collected - 1 : collected]
            self.collect(first * block, collected, self._channels(arrays))

    def _channels(self, arrays: Sequence[np.ndarray]) -> Tree:
        """Return the recorded channels as arrays [frames, ..., lanes]."""
        leaves, structure = jax.tree.flatten(self.kernel.channels)
        shaped = [
            array.reshape(len(array), *leaf.shape[:-1], array.shape[-1])
            for array, leaf in zip(arrays, leaves, strict=True)
        ]
        pairs = zip(shaped, leaves, strict=True)
        return jax.tree.unflatten(structure, [x != 0 if y.dtype == bool else x for x, y in pairs])
