"""Episodes on XLA: the plain reference, a GPU's engine, and that of parts that need it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

from tegotae._support.transforms import jit_with_static
from tegotae.parts._shapes import Index
from tegotae.parts.bodies import Body
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, LoopState, Shared
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.timing import Timing, by_blocks

LANES_OF_A_BLOCK = 512
"""Lanes that a CPU advances together. Always so many, the last block filled up, so that a lane's
arithmetic does not depend on how many go with it."""


def roll_out_xla(
    program: EpisodeProgram,
    timing: Timing,
    summary: Callable[..., Any],
    lanes: LaneInputs,
    body: Body,
) -> Any:
    """Roll out; return the summary of every lane as NumPy arrays, lanes last.

    Args:
        program: what is advanced and recorded.
        timing: for how long, and how finely.
        summary: what is kept of a block's trajectory (`Rollout`).
        lanes: NumPy arrays of the same type.
        body: a body of such numbers.
    """
    block = lanes_of_a_block(lanes.weights.shape[-1])

    def summarised(lanes: LaneInputs) -> Any:
        return _block(program, timing, summary, lanes, body)

    return by_blocks(summarised, lanes, block)


def lanes_of_a_block(count: int) -> int:
    """Return the number of lanes advanced together: a block on a CPU, all of them on a GPU."""
    return LANES_OF_A_BLOCK if jax.default_backend() == "cpu" else count


def _roll_out_block(
    program: EpisodeProgram,
    timing: Timing,
    summary: Callable[..., Any],
    lanes: LaneInputs,
    body: Body,
) -> Any:
    shared = Shared(body, jnp.asarray(timing.tick_s, lanes.weights.dtype))
    ticks = jnp.arange(timing.ticks_per_frame)

    def tick(state: LoopState, index: Index) -> tuple[LoopState, None]:
        return program.tick(lanes, shared, state, index), None

    def frame(state: LoopState, number: Index) -> tuple[LoopState, Trajectory]:
        first = number * timing.ticks_per_frame
        state, _ = jax.lax.scan(tick, state, first + ticks)
        return program.frame(lanes, shared, state, first + timing.ticks_per_frame - 1)

    start = program.start(lanes, shared)
    _, trajectory = jax.lax.scan(frame, start, jnp.arange(timing.n_frames))
    return summary(trajectory, lanes.scenario, body, timing)


_block = jit_with_static(_roll_out_block, (0, 1, 2))
