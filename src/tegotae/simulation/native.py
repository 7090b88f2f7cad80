"""Episodes as native code: compiled once a program, run on all cores, summarised block by block."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np
from jax.typing import DTypeLike

from tegotae._support.engines import EngineWarning, available_cores
from tegotae._support.transforms import compiled_for
from tegotae.lowering.nodes import CannotLower
from tegotae.parts.bodies import Body
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, Shared
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.timing import Timing, filled
from tegotae.simulation.world import Scenario

if TYPE_CHECKING:
    from tegotae.lowering.episode import Kernel

LANES_SUMMARISED = 64
"""Lanes of a block that is summarised at a time: always so many, the last block filled up, so that
a lane's arithmetic does not depend on how many go with it."""
_PROGRAMS = 64
"""Compiled programs that are kept, those used last."""


def roll_out(
    program: EpisodeProgram,
    timing: Timing,
    summary: Callable[..., Any],
    lanes: LaneInputs,
    body: Body,
) -> Any:
    """The summary of every lane, as NumPy arrays, lanes last.

    Memory does not grow with frames x lanes: a summary is made of a group of lanes as soon as these
    have been rolled out.

    Args:
        program: what is advanced and recorded.
        timing: for how long, and how finely.
        summary: what is kept of a block's trajectory (`Engine`).
        lanes: NumPy arrays of the same type.
        body: a body of such numbers.

    Raises:
        CannotLower: for a program with an operation that there is no native code for.
    """
    dtype, count = lanes.weights.dtype, lanes.weights.shape[-1]
    shared = Shared(body, np.asarray(timing.tick_s, dtype))
    shapes = _Shapes.of(lanes, shared)
    kernel = _kernel(program, shapes)
    if isinstance(kernel, CannotLower):
        raise kernel
    summarised = _summarised(timing, summary, _Block.of(kernel, timing, shapes))

    def whole(like: jax.ShapeDtypeStruct) -> np.ndarray:
        return np.empty((*like.shape[:-1], count), like.dtype)

    found = jax.tree.map(whole, summarised.out_info)

    def put(at: slice, whole: np.ndarray, some: jax.Array) -> None:
        whole[..., at] = np.asarray(some)[..., : at.stop - at.start]

    def collect(first: int, n: int, trajectory: Trajectory) -> None:
        with jax.enable_x64(dtype == "float64"):  # a setting of each thread
            for at in range(0, n, LANES_SUMMARISED):
                here = slice(at, min(at + LANES_SUMMARISED, n))
                there = slice(first + here.start, first + here.stop)
                given = filled(trajectory, here, LANES_SUMMARISED)
                met = filled(lanes.scenario, there, LANES_SUMMARISED)
                part = summarised(given, met, shared.body)
                jax.tree.map(partial(put, there), found, part)

    kernel.run(
        lanes,
        shared,
        frames=timing.n_frames,
        ticks_per_frame=timing.ticks_per_frame,
        threads=available_cores(),
        collect=collect,
    )
    return found


def cannot_lower(program: EpisodeProgram, lanes: LaneInputs, body: Body) -> str:
    """The operation of a program that there is no native code for, of which it warns; or none.

    Args:
        program: what is advanced and recorded.
        lanes: such as it is run with; how many there are does not matter.
        body: a body.
    """
    dtype = lanes.weights.dtype
    body = numbers_of(body, dtype)
    kernel = _kernel(program, _Shapes.of(lanes, Shared(body, np.asarray(0.0, dtype))))
    return kernel.operation if isinstance(kernel, CannotLower) else ""


def numbers_of(body: Body, dtype: DTypeLike) -> Body:
    """The body with its numbers as NumPy arrays of one type.

    Args:
        body: a body, whose numbers may be of any type.
        dtype: float32 or float64.
    """

    def number(x: object) -> np.ndarray:
        return np.asarray(x, dtype)

    return jax.tree.map(number, body)


class _Shapes(NamedTuple):
    """Of what a kernel is given: hashable."""

    structure: Any
    lanes: tuple[tuple[int, ...], ...]
    """Shapes of arrays that each lane has of its own, without the axis of the lanes."""
    shared: tuple[tuple[int, ...], ...]
    """Shapes of arrays that all lanes share."""
    dtype: str

    @classmethod
    def of(cls, lanes: LaneInputs, shared: Shared) -> _Shapes:
        own, ours = jax.tree.leaves(lanes), jax.tree.leaves(shared)
        return cls(
            jax.tree.structure((lanes, shared)),
            tuple(x.shape[:-1] for x in own),
            tuple(np.shape(x) for x in ours),
            str(lanes.weights.dtype),
        )

    def arrays(self, lanes: int) -> tuple[LaneInputs, Shared]:
        """Arrays of so many lanes, by their shapes alone."""
        shapes = *((*shape, lanes) for shape in self.lanes), *self.shared
        each = [jax.ShapeDtypeStruct(shape, self.dtype) for shape in shapes]
        own, shared = jax.tree.unflatten(self.structure, each)
        return own, shared


@lru_cache(_PROGRAMS)
def _kernel(program: EpisodeProgram, shapes: _Shapes) -> Kernel | CannotLower:
    """A program's code, or why there is none."""
    from tegotae.lowering.episode import TracedEpisode, compile_episode  # llvmlite may be missing

    episode = TracedEpisode(program.start, program.tick, program.frame)
    lanes, shared = shapes.arrays(1)
    with jax.enable_x64(shapes.dtype == "float64"):
        try:
            return compile_episode(episode, lanes, shared, shapes.dtype)
        except CannotLower as error:
            warnings.warn(
                f"{error}; XLA runs the rollouts of this controller, more slowly",
                EngineWarning,
                stacklevel=2,
            )
            return error


class _Block(NamedTuple):
    """What a summary is given of a block, by shapes alone: hashable."""

    structure: Any
    leaves: tuple[jax.ShapeDtypeStruct, ...]
    dtype: str

    @classmethod
    def of(cls, kernel: Kernel, timing: Timing, shapes: _Shapes) -> _Block:
        lanes, shared = shapes.arrays(LANES_SUMMARISED)

        def of_frames(x: jax.ShapeDtypeStruct) -> jax.ShapeDtypeStruct:
            return jax.ShapeDtypeStruct((timing.n_frames, *x.shape[:-1], LANES_SUMMARISED), x.dtype)

        frames = jax.tree.map(of_frames, kernel.channels)
        leaves, structure = jax.tree.flatten((frames, lanes.scenario, shared.body))
        return cls(structure, tuple(leaves), shapes.dtype)


@lru_cache(_PROGRAMS)
def _summarised(timing: Timing, summary: Callable[..., Any], block: _Block) -> jax.stages.Compiled:
    """The summary of a block, compiled: one for all controllers whose recordings are alike."""

    def of_block(trajectory: Trajectory, scenario: Scenario, body: Body) -> Any:
        return summary(trajectory, scenario, body, timing)

    with jax.enable_x64(block.dtype == "float64"):
        return compiled_for(of_block, *jax.tree.unflatten(block.structure, block.leaves))


def forget_programs() -> None:
    """Give back the memory of all compiled programs, native and XLA's."""
    _kernel.cache_clear()
    _summarised.cache_clear()
    jax.clear_caches()
