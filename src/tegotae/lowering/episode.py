"""Episodes of many lanes as native code: a program of pure JAX functions, and the kernel of it."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import jax
import numpy as np

from tegotae._support.engines import available_cores
from tegotae.lowering.layout import aligned
from tegotae.lowering.machine import Code, Target, target_of
from tegotae.lowering.module import EpisodeModule
from tegotae.lowering.native_reader import NativeReader
from tegotae.lowering.nodes import KINDS, LANE, TICK, UNIFORM, Node, Tree, array_of, given, scalars
from tegotae.lowering.placement import Stages

_BUFFER_BYTES = 4 * 2**20
"""Frames that a thread records before they are collected, unless a block alone has more."""

_GROUPS_OF_THREAD = 4
"""Groups that a thread has at least, where there are so many lanes."""
_LANES_TOGETHER = 64
"""Lanes of a group, or a multiple of them: so many are summarised at a time."""

Collect = Callable[[int, int, Tree], None]
"""Takes the first lane of a group, how many it has, and its channels [frames, ..., lanes]."""


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
) -> Kernel:
    """The kernel of a program, traced, read and compiled.

    Args:
        episode: the program.
        lanes_shapes: the pytree that `run` takes lane by lane, such as weights and scenario, as
            arrays or `jax.ShapeDtypeStruct` of shape [..., lanes]; how many lanes is ignored.
        shared_shapes: the pytree that all lanes share, of shape [...].
        dtype: "float32" or "float64".
        target: "host", "avx2", "avx512", "aarch64", "scalar", or a `Target`.
        vectors: vectors of lanes that a block has. Results do not depend on it.

    Raises:
        CannotLower: for an operation that has no native code, by its name and place.
    """
    chosen = target_of(target)
    with jax.enable_x64(dtype == "float64"):
        lanes = jax.tree.map(_of_one_lane, lanes_shapes)
        shared = jax.tree.map(_shape, shared_shapes)
        stages, channels = _read(episode, lanes, shared)
    kinds = tuple(kind for leaf in jax.tree.leaves(lanes) for kind in _kinds(leaf))
    module = EpisodeModule(stages, kinds, chosen, dtype, vectors)
    shared_dtypes = [str(leaf.dtype) for leaf in jax.tree.leaves(shared) for _ in _kinds(leaf)]
    return Kernel(channels, module, tuple(shared_dtypes), Code.compiled(module.text(), chosen))


def _shape(x: jax.Array | jax.ShapeDtypeStruct) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(x.shape, x.dtype)


def _of_one_lane(x: jax.Array | jax.ShapeDtypeStruct) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct((*x.shape[:-1], 1), x.dtype)


def _read(episode: TracedEpisode, lanes: Tree, shared: Tree) -> tuple[Stages, Tree]:
    """A program, traced for one lane; and what a frame records, as shapes."""
    reader = NativeReader()

    def read(function: Callable[..., Tree], **inputs: Tree) -> tuple[list[Node], Tree]:
        trace, shapes = jax.make_jaxpr(function, return_shape=True)(*inputs.values())
        arrays = [array for name, tree in inputs.items() for array in _given(name, tree)]
        return scalars(reader.read(trace, arrays)), shapes

    start, state = read(episode.start, lanes=lanes, shared=shared)
    index = jax.ShapeDtypeStruct((), "int32")
    inputs = {"lanes": lanes, "shared": shared, "state": jax.tree.map(_shape, state)}
    tick, _ = read(episode.tick, **inputs, index=index)
    frame, (_, channels) = read(episode.frame, **inputs, index=index)
    return Stages(start, tick, frame[: len(start)], frame[len(start) :]), channels


def _kinds(leaf: jax.Array | jax.ShapeDtypeStruct) -> list[str]:
    return [KINDS[str(leaf.dtype)]] * int(np.prod(leaf.shape, dtype=int))


_STAGES = {"shared": UNIFORM, "lanes": LANE, "state": TICK, "index": TICK}


def _given(name: str, tree: Tree) -> list[np.ndarray]:
    """Nodes of what is given, leaf by leaf, numbered one after the other."""
    numbers, stage = itertools.count(), _STAGES[name]
    return [
        array_of([given((name, next(numbers)), kind, stage) for kind in _kinds(leaf)], leaf.shape)
        for leaf in jax.tree.leaves(tree)
    ]


@dataclass(frozen=True)
class Kernel:
    """A compiled program of lanes.

    A lane's results are the same bits whatever its neighbours, the vectors of a block, the
    processor, and the number of threads.
    """

    channels: Tree
    """What a frame records, as `jax.ShapeDtypeStruct` of one lane."""
    module: EpisodeModule = field(repr=False)
    shared_dtypes: Sequence[str] = field(repr=False)
    """Types of what all lanes share, number by number."""
    code: Code = field(repr=False)

    def run(
        self,
        lanes: Tree,
        shared: Tree,
        *,
        frames: int,
        ticks_per_frame: int,
        threads: int | None = None,
        collect: Collect,
    ) -> None:
        """Roll out every lane; a last block is filled up with the last lane.

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
        leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(lanes)]
        count = leaves[0].shape[-1]
        rows = [leaf.reshape(-1, count) for leaf in leaves]
        run = _Run(self, rows, self._uniform(shared), frames, ticks_per_frame, collect)
        blocks = -(-count // self.module.block)
        threads = max(1, min(threads or available_cores(), blocks))
        group = self._blocks_of_group(blocks, threads, frames)
        firsts, lock = iter(range(0, blocks, group)), threading.Lock()

        def work() -> None:
            worker = _Worker(run, group)
            while True:
                with lock:
                    first = next(firsts, None)
                if first is None:
                    return
                worker.roll_out(first, min(group, blocks - first))

        if threads == 1:
            work()
            return
        with ThreadPoolExecutor(threads) as pool:
            for done in [pool.submit(work) for _ in range(threads)]:
                done.result()

    def _uniform(self, shared: Tree) -> np.ndarray:
        """What all lanes share, computed once."""
        memory = aligned(8 * len(self.shared_dtypes))
        uniform = aligned(self.module.uniform_bytes)
        numbers = [x for leaf in jax.tree.leaves(shared) for x in np.asarray(leaf).reshape(-1)]
        for i, (number, dtype) in enumerate(zip(numbers, self.shared_dtypes, strict=True)):
            stored = "int32" if dtype == "bool" else dtype
            np.ndarray((1,), stored, memory.data, 8 * i)[0] = number
        self.code.function("uniform", 2)(memory.ctypes.data, uniform.ctypes.data)
        return uniform

    def _blocks_of_group(self, blocks: int, threads: int, frames: int) -> int:
        """As many as the buffer holds, few enough that no thread waits long for another."""
        block = self.module.block
        frame_bytes = self.module.channel_rows.size * block * frames
        fits = max(1, _BUFFER_BYTES // max(1, frame_bytes))
        together = max(1, _LANES_TOGETHER // block)
        shares = -(-blocks // (_GROUPS_OF_THREAD * threads * together)) * together
        return min(fits, shares)


@dataclass(frozen=True)
class _Run:
    """One run of a kernel: what all threads share."""

    kernel: Kernel
    rows: Sequence[np.ndarray]
    """What is given lane by lane, [rows, lanes], leaf by leaf."""
    uniform: np.ndarray
    frames: int
    ticks: int
    collect: Collect


class _Worker:
    """The memory of a thread, and what it does with a group of blocks."""

    def __init__(self, run: _Run, group: int) -> None:
        module, code = run.kernel.module, run.kernel.code
        self._run, self._module, self._block = run, module, module.block
        rows = (module.lane_rows, module.invariant_rows, module.state_rows)
        self._given, self._invariant, self._state = (x.memory(module.block) for x in rows)
        self._out = module.channel_rows.memory(module.block * group, run.frames)
        self._start, self._episode = code.function("start", 4), code.function("episode", 4, 4)
        ends = itertools.accumulate(len(leaf) for leaf in run.rows)
        self._leaves = [
            module.lane_rows.view(self._given, end - len(leaf), end, module.block)[0]
            for leaf, end in zip(run.rows, ends, strict=True)
        ]

    def roll_out(self, first: int, blocks: int) -> None:
        """Roll out so many blocks from the first one on, and let them be collected."""
        run, block, row = self._run, self._block, self._block * blocks
        all_lanes = run.rows[0].shape[-1]
        uniform, given, invariant, state, out = (
            memory.ctypes.data
            for memory in (run.uniform, self._given, self._invariant, self._state, self._out)
        )
        for number in range(blocks):
            lane = (first + number) * block
            lanes = min(block, all_lanes - lane)
            for leaf, rows in zip(run.rows, self._leaves, strict=True):
                rows[:, :lanes] = leaf[:, lane : lane + lanes]
                rows[:, lanes:] = leaf[:, -1:]
            self._start(given, uniform, invariant, state)
            self._episode(
                uniform, invariant, state, out, run.frames, run.ticks, row, number * block
            )
        lanes = min(row, all_lanes - first * block)
        run.collect(first * block, lanes, self._channels(row, lanes))

    def _channels(self, row: int, lanes: int) -> Tree:
        """What was recorded, as arrays [frames, ..., lanes]."""
        frames, first, arrays = self._run.frames, 0, []
        leaves, structure = jax.tree.flatten(self._run.kernel.channels)
        for leaf in leaves:
            last = first + int(np.prod(leaf.shape, dtype=int))
            view = self._module.channel_rows.view(self._out, first, last, row, frames)
            array = view.reshape(frames, *leaf.shape[:-1], row)[..., :lanes]
            arrays.append(array != 0 if leaf.dtype == bool else array)
            first = last
        return jax.tree.unflatten(structure, arrays)
