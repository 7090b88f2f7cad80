"""Episodes as native code: compiled once a program, run on all cores, summarised block by block."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np
from jax.typing import DTypeLike

from lanewise.nodes import CannotLower
from tegotae._support import compiled
from tegotae._support.engines import EngineWarning, available_cores
from tegotae._support.transforms import compiled_for
from tegotae.parts.bodies import Body
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, Shared
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.timing import Timing, padded_lanes
from tegotae.simulation.world import Scenario

if TYPE_CHECKING:
    from lanewise.episode import Kernel

LANES_SUMMARISED = 64
"""Lanes of a block that is summarised at a time: always so many, the last block filled up, so that
a lane's arithmetic does not depend on how many go with it."""
_PROGRAMS = 64
"""Compiled programs that are kept, those used last."""


def roll_out_native(
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
        summary: what is kept of a block's trajectory (`Rollout`).
        lanes: NumPy arrays of the same type.
        body: a body of such numbers.

    Raises:
        CannotLower: for a program with an operation that there is no native code for.
    """
    dtype, count = lanes.weights.dtype, lanes.weights.shape[-1]
    shared = Shared(body, np.asarray(timing.tick_s, dtype))
    kernel = _kernel(program, _Like.from_tree((_lanes(lanes, 1), shared)))
    if isinstance(kernel, CannotLower):
        raise kernel
    frames = _lanes(kernel.channels, LANES_SUMMARISED, timing.n_frames)
    block = frames, _lanes(lanes.scenario, LANES_SUMMARISED), shared.body
    summarised = _summarised(timing, summary, _Like.from_tree(block))

    def output(like: jax.ShapeDtypeStruct) -> np.ndarray:
        return np.empty((*like.shape[:-1], count), like.dtype)

    results = jax.tree.map(output, summarised.out_info)

    def put(offset: slice, output: np.ndarray, some: jax.Array) -> None:
        output[..., offset] = np.asarray(some)[..., : offset.stop - offset.start]

    def collect(first: int, n: int, trajectory: Trajectory) -> None:
        with jax.enable_x64(dtype == "float64"):  # a setting of each thread
            for offset in range(0, n, LANES_SUMMARISED):
                lanes_slice = slice(first + offset, first + min(offset + LANES_SUMMARISED, n))
                summed = padded_lanes(
                    trajectory, slice(offset, offset + LANES_SUMMARISED), LANES_SUMMARISED
                )
                met = padded_lanes(lanes.scenario, lanes_slice, LANES_SUMMARISED)
                part = summarised(summed, met, shared.body)
                jax.tree.map(partial(put, lanes_slice), results, part)

    kernel.run(
        lanes,
        shared,
        frames=timing.n_frames,
        ticks_per_frame=timing.ticks_per_frame,
        threads=available_cores(),
        collect=collect,
    )
    return results


def cannot_lower(program: EpisodeProgram, lanes: LaneInputs, body: Body) -> str:
    """The operation of a program that there is no native code for, of which it warns; or none.

    Args:
        program: what is advanced and recorded.
        lanes: such as it is run with; how many there are does not matter.
        body: a body.
    """
    dtype = lanes.weights.dtype
    shared = Shared(with_numpy_numbers(body, dtype), np.asarray(0.0, dtype))
    kernel = _kernel(program, _Like.from_tree((_lanes(lanes, 1), shared)))
    return kernel.operation if isinstance(kernel, CannotLower) else ""


def with_numpy_numbers(body: Body, dtype: DTypeLike) -> Body:
    """The body with its numbers as NumPy arrays of one type.

    Args:
        body: a body, whose numbers may be of any type.
        dtype: float32 or float64.
    """

    def number(x: object) -> np.ndarray:
        return np.asarray(x, dtype)

    return jax.tree.map(number, body)


class _Like(NamedTuple):
    """Arrays by their shapes and types alone: hashable."""

    structure: Any
    leaves: tuple[jax.ShapeDtypeStruct, ...]

    @classmethod
    def from_tree(cls, tree: Any) -> _Like:
        leaves, structure = jax.tree.flatten(tree)
        return cls(structure, tuple(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in leaves))

    @property
    def tree(self) -> Any:
        return jax.tree.unflatten(self.structure, self.leaves)


def _lanes(tree: Any, count: int, *leading: int) -> Any:
    """The shapes of arrays, with so many lanes and other axes before their own."""

    def like(x: Any) -> jax.ShapeDtypeStruct:
        return jax.ShapeDtypeStruct((*leading, *x.shape[:-1], count), x.dtype)

    return jax.tree.map(like, tree)


@lru_cache(_PROGRAMS)
def _kernel(program: EpisodeProgram, inputs: _Like) -> Kernel | CannotLower:
    """A program's code, or why there is none."""
    from lanewise.episode import TracedEpisode, compile_episode  # llvmlite may be missing

    episode = TracedEpisode(program.start, program.tick, program.frame)
    lanes, shared = inputs.tree
    dtype = lanes.weights.dtype.name
    with jax.enable_x64(dtype == "float64"):
        try:
            return compile_episode(episode, lanes, shared, dtype, store=compiled)
        except CannotLower as error:
            warnings.warn(
                f"{error}; XLA runs the rollouts of this controller, more slowly",
                EngineWarning,
                stacklevel=2,
            )
            return error


@lru_cache(_PROGRAMS)
def _summarised(timing: Timing, summary: Callable[..., Any], block: _Like) -> jax.stages.Compiled:
    """The summary of a block, compiled: one for all controllers whose recordings are alike."""

    def of_block(trajectory: Trajectory, scenario: Scenario, body: Body) -> Any:
        return summary(trajectory, scenario, body, timing)

    frames, scenario, body = block.tree
    with jax.enable_x64(scenario.omega.dtype == "float64"):
        return compiled_for(of_block, frames, scenario, body)


def forget_programs() -> None:
    """Give back the memory of all compiled programs, native and XLA's."""
    _kernel.cache_clear()
    _summarised.cache_clear()
    jax.clear_caches()
