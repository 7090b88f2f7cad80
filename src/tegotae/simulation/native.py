"""Episodes as native code: compiled once a program, run on all cores, summarised block by block."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache
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
from tegotae.simulation.summaries import KeptChannels, Summary, Together
from tegotae.simulation.timing import Timing, padded_lanes
from tegotae.simulation.world import Scenario

if TYPE_CHECKING:
    from lanewise.episode import Kernel

LANES_SUMMARISED = 64
"""Lanes of a block that is summarised at a time: always so many, the last block filled up, so that
a lane's arithmetic does not depend on how many go with it."""
LANES_OF_LONG_RECORDINGS = 8
"""Lanes of a block of more than `LONG_FRAMES` frames, which take so much memory."""
LONG_FRAMES = 2**14
_PROGRAMS = 64
"""Compiled programs that are kept, those used last."""


def roll_out_native(
    program: EpisodeProgram,
    timing: Timing,
    summary: Summary,
    lanes: LaneInputs,
    body: Body,
) -> Any:
    """Roll out; return the summary of every lane as NumPy arrays, lanes last.

    A summary is made of a group of lanes as soon as these have been rolled out, and only its result
    is kept. `KeptChannels` are copied lane by lane; the others are computed of blocks of lanes.

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
    parts = summary.parts if isinstance(summary, Together) else (summary,)
    copied = Together(tuple(part for part in parts if isinstance(part, KeptChannels)))
    computed = Together(tuple(part for part in parts if not isinstance(part, KeptChannels)))
    channels = kernel.channels.only(copied.needs)
    recording = _new_arrays(_lanes(channels, count, timing.n_frames))
    results, summarise = _blocks(computed, timing, kernel.channels, lanes, body)

    def collect(first: int, n: int, trajectory: Trajectory) -> None:
        _put(recording, slice(first, first + n), trajectory.only(recording.channels))
        summarise(first, n, trajectory)

    kernel.run(
        lanes,
        shared,
        frames=timing.n_frames,
        ticks_per_frame=timing.ticks_per_frame,
        threads=available_cores(),
        collect=collect,
    )
    numbers = iter(results)
    of_parts = tuple(
        recording.only(part.needs) if isinstance(part, KeptChannels) else next(numbers)
        for part in parts
    )
    return of_parts if isinstance(summary, Together) else of_parts[0]


def _blocks(
    summaries: Together, timing: Timing, channels: Trajectory, lanes: LaneInputs, body: Body
) -> tuple[tuple[Any, ...], Callable[[int, int, Trajectory], None]]:
    """Return the results of summaries, to be filled, and the function that fills in those of a
    group of lanes, given its first, block by block.
    """
    if not summaries.parts:
        return (), lambda first, n, trajectory: None
    dtype, count = lanes.weights.dtype, lanes.weights.shape[-1]
    size = LANES_SUMMARISED if timing.n_frames <= LONG_FRAMES else LANES_OF_LONG_RECORDINGS
    frames = _lanes(channels.only(summaries.needs), size, timing.n_frames)
    block = frames, _lanes(lanes.scenario, size), body
    summarised = _summarised(timing, summaries, _Like.from_tree(block))
    results = _new_arrays(_lanes(summarised.out_info, count))

    def summarise(first: int, n: int, trajectory: Trajectory) -> None:
        recorded = trajectory.only(summaries.needs)
        with jax.enable_x64(dtype == "float64"):  # a setting of each thread
            for offset in range(0, n, size):
                group = slice(first + offset, first + min(offset + size, n))
                summed = padded_lanes(recorded, slice(offset, offset + size), size)
                met = padded_lanes(lanes.scenario, group, size)
                _put(results, group, summarised(summed, met, body))

    return results, summarise


def cannot_lower(program: EpisodeProgram, lanes: LaneInputs, body: Body) -> str:
    """Return the operation of a program that has no native code, after a warning, or None.

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
    """Return the body with its numbers as NumPy arrays of one type.

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


def _new_arrays(shapes: Any) -> Any:
    """Return arrays of these shapes, to be filled."""

    def new_array(like: jax.ShapeDtypeStruct) -> np.ndarray:
        return np.empty((*like.shape,), like.dtype)

    return jax.tree.map(new_array, shapes)


def _put(results: Any, lanes: slice, values: Any) -> None:
    """Write values of some lanes, and perhaps more behind them, into arrays of all lanes."""

    def put(array: np.ndarray, value: jax.Array | np.ndarray) -> None:
        array[..., lanes] = np.asarray(value)[..., : lanes.stop - lanes.start]

    jax.tree.map(put, results, values)


def _lanes(tree: Any, count: int, *leading: int) -> Any:
    """Return the shapes of arrays, with so many lanes and other axes before their own."""

    def like(x: Any) -> jax.ShapeDtypeStruct:
        return jax.ShapeDtypeStruct((*leading, *x.shape[:-1], count), x.dtype)

    return jax.tree.map(like, tree)


@lru_cache(_PROGRAMS)
def _kernel(program: EpisodeProgram, inputs: _Like) -> Kernel | CannotLower:
    """Return a program's code, or the reason why there is none."""
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
def _summarised(timing: Timing, summary: Summary, block: _Like) -> jax.stages.Compiled:
    """Return the compiled summary of a block, shared by all controllers whose recordings are
    alike.
    """

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
