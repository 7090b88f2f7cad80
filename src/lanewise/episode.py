"""Episodes of many lanes as native code: a program of pure JAX functions, and the kernel of it."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache, cached_property, partial

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
    """Trace and read the kernel of a program, which is compiled when it first runs.

    Args:
        episode: the program.
        lanes_shapes: the pytree that `run` takes lane by lane, such as weights and scenario, as
            arrays or `jax.ShapeDtypeStruct` of shape [..., lanes]; how many lanes is ignored.
        shared_shapes: the pytree that all lanes share, of shape [...].
        dtype: "float32" or "float64".
        target: "host", "avx2", "avx512", "aarch64", "scalar", or a `Target`.
        vectors: vectors of lanes that a block has; a last block of fewer lanes has one. Results do
            not depend on it.
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
    full, narrow = (
        Blocks(EpisodeModule(stages, _kinds(lanes), recorded, machine, dtype, size), store)
        for size in (vectors, 1)
    )
    return Kernel(channels, _kinds(shared), full, narrow)


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


@dataclass(frozen=True, eq=False)
class Blocks:
    """A program in blocks of one size, compiled when it is first used."""

    module: EpisodeModule
    store: Store | None

    @cached_property
    def code(self) -> Code:
        """The machine code."""
        return Code.compiled(self.module.text(), self.module.target, store=self.store)


@dataclass(frozen=True)
class Kernel:
    """A program of lanes, in blocks of two sizes.

    A lane's results are the same bits whatever its neighbours, the vectors of a block, the
    processor, and the number of threads.
    """

    channels: Tree
    """Channels of a frame, as `jax.ShapeDtypeStruct` of one lane."""
    shared_kinds: tuple[str, ...] = field(repr=False)
    """Types in C of what all lanes share, number by number."""
    full: Blocks = field(repr=False)
    """Blocks of full size."""
    narrow: Blocks = field(repr=False)
    """Blocks of one vector, for the last lanes."""

    def blocks_for(self, lanes: int) -> Blocks:
        """Return the blocks in which the first of so many lanes are rolled out."""
        return self.narrow if lanes <= self.narrow.module.block else self.full

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
        blocks = -(-count // self.full.module.block)
        threads = max(1, min(threads, blocks))
        group = self._lanes_of_group(blocks, threads, frames)
        uniform = self._uniform(shared, self.blocks_for(count))
        run = _Run(self, rows, uniform, frames, ticks_per_frame, group, collect)
        firsts, lock = iter(range(0, count, group)), threading.Lock()

        def next_first() -> int | None:
            with lock:
                return next(firsts, None)

        if threads == 1:
            run.work(next_first)
            return
        with ThreadPoolExecutor(threads) as pool:
            for future in [pool.submit(run.work, next_first) for _ in range(threads)]:
                future.result()

    def _uniform(self, shared: Tree, blocks: Blocks) -> np.ndarray:
        """Compute the values that all lanes share, once."""
        memory = aligned(8 * len(self.shared_kinds))
        uniform = aligned(blocks.module.uniform_bytes)
        numbers = [x for leaf in jax.tree.leaves(shared) for x in np.asarray(leaf).reshape(-1)]
        for i, (number, dtype) in enumerate(
            zip(numbers, Rows(self.shared_kinds).dtypes, strict=True)
        ):
            np.ndarray((1,), dtype, memory.data, 8 * i)[0] = number
        blocks.code.function("uniform", 2)(memory.ctypes.data, uniform.ctypes.data)
        return uniform

    def _lanes_of_group(self, blocks: int, threads: int, frames: int) -> int:
        """Return the lanes per group: as many blocks as the buffer holds, few enough that no thread
        waits long."""
        module = self.full.module
        fits = max(1, _BUFFER_BYTES // max(1, module.recorded.size * module.block * frames))
        together = max(1, _LANES_TOGETHER // module.block)
        shares = -(-blocks // (_GROUPS_OF_THREAD * threads * together)) * together
        return min(fits, shares) * module.block


@dataclass(frozen=True, eq=False)
class _Run:
    """One run of a kernel: the state that all threads share."""

    kernel: Kernel
    rows: Sequence[np.ndarray]
    """Inputs of each lane, [rows, lanes], leaf by leaf."""
    uniform: np.ndarray
    frames: int
    ticks: int
    group: int
    """Lanes that are collected at a time."""
    collect: Collect

    def work(self, next_first: Callable[[], int | None]) -> None:
        """Roll out group after group, by their first lanes, in memory of this thread's own."""
        recorded = self.kernel.full.module.recorded
        out = recorded.memory(self.frames, self.group)
        program = cache(partial(self._program, out))
        while (first := next_first()) is not None:
            collected, column = min(self.group, self.rows[0].shape[-1] - first), 0
            while column < collected:
                blocks = self.kernel.blocks_for(collected - column)
                program(blocks)(first + column, column)
                column += blocks.module.block
            arrays = recorded.views(out, self.frames, self.group)
            for array in arrays:  # a block has filled itself up
                array[..., column:] = array[..., collected - 1 : collected]
            self.collect(first, collected, self._channels(arrays))

    def _program(self, out: np.ndarray, blocks: Blocks) -> Callable[[int, int], None]:
        """Return a function of a block's first lane, and its column in `out`, that rolls it out."""
        module, code = blocks.module, blocks.code
        tables = (module.lane_rows, module.invariant_rows, module.state_rows)
        inputs, invariant, state = (rows.memory(module.block) for rows in tables)
        memory = inputs, self.uniform, invariant, state, out
        start, episode = code.function("start", 4), code.function("episode", 5, 4)
        ends = itertools.accumulate(len(leaf) for leaf in self.rows)
        leaves = [
            module.lane_rows.view(inputs, end - len(leaf), end, module.block)
            for leaf, end in zip(self.rows, ends, strict=True)
        ]

        def roll_out(lane: int, column: int) -> None:
            for leaf, rows in zip(self.rows, leaves, strict=True):
                lanes = leaf[:, lane : lane + module.block]
                rows[:, : lanes.shape[1]] = lanes
                rows[:, lanes.shape[1] :] = leaf[:, -1:]
            pointers = [array.ctypes.data for array in memory]
            start(*pointers[:-1])
            episode(*pointers, self.frames, self.ticks, self.group, column)

        return roll_out

    def _channels(self, arrays: Sequence[np.ndarray]) -> Tree:
        """Return the recorded channels as arrays [frames, ..., lanes]."""
        leaves, structure = jax.tree.flatten(self.kernel.channels)
        shaped = [
            array.reshape(len(array), *leaf.shape[:-1], array.shape[-1])
            for array, leaf in zip(arrays, leaves, strict=True)
        ]
        pairs = zip(shaped, leaves, strict=True)
        return jax.tree.unflatten(structure, [x != 0 if y.dtype == bool else x for x, y in pairs])
