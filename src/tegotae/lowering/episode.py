"""Episodes of many lanes as native code: a program of pure JAX functions, and the kernel of it."""

from __future__ import annotations

import ctypes
import itertools
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import jax
import numpy as np

from tegotae._support.engines import available_cores
from tegotae.lowering.layout import aligned
from tegotae.lowering.llvm.compile import Compiled, Target, target_of
from tegotae.lowering.llvm.module import EpisodeModule
from tegotae.lowering.nodes import KINDS, Node, Tree, array_of, given, scalars
from tegotae.lowering.stages import LaneReader, Roots, Stages

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
    begun = time.perf_counter()
    chosen = target_of(target)
    with jax.enable_x64(dtype == "float64"):
        read = _Read.of(episode, lanes_shapes, shared_shapes)
    module = EpisodeModule(Stages.of(read.roots), read.lane_kinds, chosen, dtype, vectors)
    code = Compiled(module.text(), chosen)
    return Kernel(
        chosen, module.block, time.perf_counter() - begun, read.channels, module, read, code
    )


@dataclass(frozen=True)
class _Read:
    """A program that was traced and read."""

    roots: Roots
    lane_kinds: tuple[str, ...]
    """Kinds of what is given lane by lane, entry by entry."""
    shared_dtypes: tuple[str, ...]
    channels: Tree
    """What a frame records, as shapes of one lane."""

    @classmethod
    def of(cls, episode: TracedEpisode, lanes: Tree, shared: Tree) -> _Read:
        """Traced for one lane."""
        lanes = jax.tree.map(lambda x: jax.ShapeDtypeStruct((*x.shape[:-1], 1), x.dtype), lanes)
        shared = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype), shared)
        index = jax.ShapeDtypeStruct((), "int32")
        reader = LaneReader()

        def read(function: Callable[..., Tree], **arguments: Tree) -> tuple[list[Node], Tree]:
            trace, shapes = jax.make_jaxpr(function, return_shape=True)(*arguments.values())
            inputs = [
                array
                for name, tree in arguments.items()
                for array in _given(name, jax.tree.leaves(tree))
            ]
            return scalars(reader.read(trace, inputs)), shapes

        start, state = read(episode.start, lanes=lanes, shared=shared)
        of_state = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype), state)
        given_all = {"lanes": lanes, "shared": shared, "state": of_state, "index": index}
        tick, _ = read(episode.tick, **given_all)
        frame, (_, channels) = read(episode.frame, **given_all)
        roots = Roots(tuple(start), tuple(tick), *_split(frame, len(start)))
        lane_kinds = [k for leaf in jax.tree.leaves(lanes) for k in _kinds(leaf)]
        dtypes = [str(leaf.dtype) for leaf in jax.tree.leaves(shared) for _ in _kinds(leaf)]
        return cls(roots, tuple(lane_kinds), tuple(dtypes), channels)


def _split(nodes: Sequence[Node], first: int) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    return tuple(nodes[:first]), tuple(nodes[first:])


def _kinds(leaf: jax.Array | jax.ShapeDtypeStruct) -> list[str]:
    return [KINDS[str(leaf.dtype)]] * int(np.prod(leaf.shape, dtype=int))


def _given(name: str, leaves: Sequence[jax.Array | jax.ShapeDtypeStruct]) -> list[np.ndarray]:
    """Nodes of what is given, leaf by leaf, numbered one after the other."""
    numbers = itertools.count()
    return [
        array_of([given((name, next(numbers)), kind) for kind in _kinds(leaf)], leaf.shape)
        for leaf in leaves
    ]


@dataclass(frozen=True)
class Kernel:
    """A compiled program of lanes.

    A lane's results are the same bits whatever its neighbours, the vectors of a block, the
    processor, and the number of threads.
    """

    target: Target
    """What it was compiled for."""
    block: int
    """Lanes that are advanced together; a last block is filled up with the last lane."""
    compile_seconds: float
    """Seconds that tracing and compiling took."""
    channels: Tree
    """What a frame records, as `jax.ShapeDtypeStruct` of one lane."""
    _module: EpisodeModule = field(repr=False)
    _read: _Read = field(repr=False)
    _code: Compiled = field(repr=False)

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
        run = _Run(self, lanes, shared, frames, ticks_per_frame, collect)
        run.go(threads or available_cores())


class _Run:
    """One run of a kernel: what all threads share."""

    def __init__(
        self,
        kernel: Kernel,
        lanes: Tree,
        shared: Tree,
        frames: int,
        ticks: int,
        collect: Collect,
    ) -> None:
        self._module, self._read, self._code = kernel._module, kernel._read, kernel._code
        self._block, self._channels = kernel.block, kernel.channels
        self._frames, self._ticks, self._collect = frames, ticks, collect
        leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(lanes)]
        self._lanes = leaves[0].shape[-1]
        self._given = [leaf.reshape(-1, self._lanes) for leaf in leaves]
        self._blocks = -(-self._lanes // self._block)
        self._uniform = aligned(self._module.uniform_bytes)
        self._spread(shared)

    def _spread(self, shared: Tree) -> None:
        """What all lanes share, computed once."""
        dtypes = self._read.shared_dtypes
        memory = aligned(8 * len(dtypes))
        entries = [x for leaf in jax.tree.leaves(shared) for x in np.asarray(leaf).reshape(-1)]
        for i, (entry, dtype) in enumerate(zip(entries, dtypes, strict=True)):
            stored = "int32" if dtype == "bool" else dtype
            np.ndarray((1,), stored, memory.data, 8 * i)[0] = entry
        self._function("uniform", 2)(memory.ctypes.data, self._uniform.ctypes.data)

    def _function(self, name: str, pointers: int, numbers: int = 0) -> Callable[..., None]:
        kinds = [ctypes.c_void_p] * pointers + [ctypes.c_int64] * numbers
        return ctypes.CFUNCTYPE(None, *kinds)(self._code.address(name))

    def go(self, threads: int) -> None:
        """Roll out group after group, each by the thread that is free."""
        threads = max(1, min(threads, self._blocks))
        group = self._blocks_of_group(threads)
        groups = iter(range(0, self._blocks, group))
        lock = threading.Lock()

        def work() -> None:
            worker = _Worker(self, group)
            while True:
                with lock:
                    first = next(groups, None)
                if first is None:
                    return
                worker.roll_out(first, min(group, self._blocks - first))

        if threads == 1:
            work()
            return
        with ThreadPoolExecutor(threads) as pool:
            for done in [pool.submit(work) for _ in range(threads)]:
                done.result()

    def _blocks_of_group(self, threads: int) -> int:
        """As many as the buffer holds, few enough that no thread waits long for another."""
        frame_bytes = self._module.channel_rows.size * self._block * self._frames
        fits = max(1, _BUFFER_BYTES // max(1, frame_bytes))
        together = max(1, _LANES_TOGETHER // self._block)
        shares = -(-self._blocks // (_GROUPS_OF_THREAD * threads * together)) * together
        return min(fits, shares)


class _Worker:
    """The memory of a thread, and what it does with a group of blocks."""

    def __init__(self, run: _Run, group: int) -> None:
        module, block = run._module, run._block
        self._run, self._block = run, block
        self._given = module.lane_rows.memory(block)
        self._invariant = module.invariant_rows.memory(block)
        self._state = module.state_rows.memory(block)
        self._out = module.channel_rows.memory(block * group, run._frames)
        self._start = run._function("start", 4)
        self._episode = run._function("episode", 4, 4)
        rows, first, self._leaves = module.lane_rows, 0, []
        for leaf in run._given:
            self._leaves.append(rows.view(self._given, first, first + len(leaf), block)[0])
            first += len(leaf)

    def roll_out(self, first: int, blocks: int) -> None:
        """Roll out so many blocks from the first one on, and let them be collected."""
        run, block, row = self._run, self._block, self._block * blocks
        uniform, given, invariant, state, out = (
            each.ctypes.data
            for each in (run._uniform, self._given, self._invariant, self._state, self._out)
        )
        for number in range(blocks):
            at = (first + number) * block
            lanes = min(block, run._lanes - at)
            for leaf, rows in zip(run._given, self._leaves, strict=True):
                rows[:, :lanes] = leaf[:, at : at + lanes]
                rows[:, lanes:] = leaf[:, -1:]
            self._start(given, uniform, invariant, state)
            self._episode(
                uniform, invariant, state, out, run._frames, run._ticks, row, number * block
            )
        lanes = min(row, run._lanes - first * block)
        run._collect(first * block, lanes, self._channels(row, lanes))

    def _channels(self, row: int, lanes: int) -> Tree:
        """What was recorded, as arrays [frames, ..., lanes]."""
        run, first, found = self._run, 0, []
        leaves, structure = jax.tree.flatten(run._channels)
        for leaf in leaves:
            last = first + int(np.prod(leaf.shape, dtype=int))
            view = run._module.channel_rows.view(self._out, first, last, row, run._frames)
            array = view.reshape(run._frames, *leaf.shape[:-1], row)[..., :lanes]
            found.append(array != 0 if leaf.dtype == bool else array)
            first = last
        return jax.tree.unflatten(structure, found)
