"""What counts as hopping, and the table of hops: the gait's Poincaré section at the apex."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.simulation.rollout import Trajectory

HOP_CLEARANCE = 0.01
"""A hop clears the rest length of the leg by at least this share of it.

A constant push leaves a damped leg bouncing on the spot of touchdown, ever lower but for ever:
such a bounce is no hop.
"""


def hop_height_m(rest_length_m: Numeric, ground_m: Numeric = 0.0) -> Numeric:
    """The least height of a hop's apex, `(1 + 0.01) l0 + h` [m].

    Args:
        rest_length_m: rest length of the leg l0 [m].
        ground_m: height of the ground h [m].
    """
    return (1.0 + HOP_CLEARANCE) * rest_length_m + ground_m


REST_SHARE = 0.25
"""A body that makes no hop in this last share of its time rests."""


def dies_out(last_hop_s: Numeric, duration_s: Numeric) -> AnyArray | np.bool | bool:
    """Whether a gait is over: no hop in the last quarter of the time from the release on.

    Args:
        last_hop_s: time of the last apex of a hop [s], any shape; minus infinity without one.
        duration_s: the time that it is looked at, from the release on [s].

    Example:
        >>> bool(dies_out(14.0, 20.0)), bool(dies_out(16.0, 20.0))
        (True, False)
    """
    return last_hop_s < (1.0 - REST_SHARE) * duration_s


def left_out(whole: AnyArray) -> jax.Array:
    """How many whole hops are left out at their beginning: one of an odd number of three or more.

    So a gait that alternates between two hops is credited for both alike.

    Args:
        whole: number of whole hops, any shape.

    Example:
        >>> left_out(jnp.arange(6)).tolist()
        [0, 0, 0, 1, 0, 1]
    """
    return jnp.where((whole > 2) & (whole % 2 == 1), 1, 0)


class WholeHops(NamedTuple):
    """Whole hops, from apex to apex: what CoT⁻¹ is taken over.

    At an apex nothing is climbed and no work is done, so that totals at the end of the apex's frame
    are those at the apex. Any other window counts climbs and work of a piece of a hop.
    """

    begins: AnyArray
    """The frame of the first apex, shape [lanes]; the last frame without a hop."""
    ends: AnyArray
    """The frame of the last apex, [lanes]; the last frame without a hop."""
    n_hops: AnyArray
    """How many whole hops lie between the two, [lanes]; -1 without an apex."""

    def over(self, total: AnyArray) -> jax.Array:
        """By how much a running total [frames, lanes] grows over them, [lanes]; 0 without any."""
        grown = at_frame(total, self.ends) - at_frame(total, self.begins)
        return jnp.where(self.n_hops > 0, grown, 0.0)


def at_frame(recorded: AnyArray, frame: AnyArray) -> jax.Array:
    """The values of a recording [frames, lanes] at a frame of each lane [lanes]: shape [lanes]."""
    return jnp.take_along_axis(jnp.asarray(recorded), frame[None], axis=0)[0]


def whole_hops(apex_height_m: AnyArray, ground_m: Numeric, rest_length_m: Numeric) -> WholeHops:
    """The last whole hops of some frames: all of one or two, an even number of three or more.

    Args:
        apex_height_m: heights of apexes [m], NaN in frames without, shape [frames, lanes].
        ground_m: height of the ground h [m], [frames, lanes].
        rest_length_m: rest length of the leg l0 [m].

    Example:
        >>> apexes = jnp.array([jnp.nan, 1.2, 1.3, 0.9, 1.2, jnp.nan, 1.3])[:, None]
        >>> found = whole_hops(apexes, 0.0, 1.0)
        >>> found.n_hops.tolist(), found.over(jnp.arange(7.0)[:, None]).tolist()
        ([2], [4.0])
    """
    # NaN in frames without an apex compares as false.
    is_hop = apex_height_m >= hop_height_m(rest_length_m, ground_m)
    frames = len(is_hop)
    number = jnp.arange(frames, dtype=jnp.int32).reshape(-1, *[1] * (is_hop.ndim - 1))

    def first(frame: AnyArray) -> jax.Array:
        return jnp.where(frame, number, frames - 1).min(axis=0)

    apexes = is_hop.sum(axis=0, dtype=jnp.int32)
    begins = first(is_hop)
    skipped = left_out(apexes - 1)
    return WholeHops(
        begins=jnp.where(skipped > 0, first(is_hop & (number > begins[None])), begins),
        ends=jnp.where(apexes > 0, jnp.where(is_hop, number, 0).max(axis=0), frames - 1),
        n_hops=apexes - 1 - skipped,
    )


class Hops(NamedTuple):
    """The apexes of the hops of every lane, in the order of time: arrays of shape [rows, lanes].

    A lane's rows after its last hop are NaN. There are as many rows as frames: no hop is lost.
    """

    time_s: AnyArray
    """Time of the apex [s]."""
    height_m: AnyArray
    """Height of the apex [m]."""
    phase_rad: AnyArray
    """Phase at the apex modulo 2π [rad]; zero without an oscillator."""
    frame: AnyArray
    """The frame in which the apex lies; that of the last frame after the last hop."""
    n_hops: AnyArray
    """How many hops the lane has, shape [lanes]."""


def hops(trajectory: Trajectory, rest_length_m: Numeric) -> Hops:
    """The hops of a trajectory: flights whose apex clears the rest length by 1 % of it.

    Args:
        trajectory: frames of shape [frames, lanes].
        rest_length_m: rest length of the leg l0 [m].

    Raises:
        TegotaeError: for a recording of several limbs, which have no one phase at an apex.
    """
    if trajectory.apex_phase_rad.ndim > 2:
        raise TegotaeError(
            "metrics of hopping are made for bodies of one limb; this recording has "
            f"{trajectory.apex_phase_rad.shape[1]}"
        )
    least = hop_height_m(rest_length_m, trajectory.ground_m)
    # NaN in frames without an apex compares as false.
    is_hop = jnp.asarray(trajectory.apex_height_m >= least)
    frames, lanes = is_hop.shape
    counted = jnp.cumsum(is_hop, axis=0, dtype=jnp.int32)
    row = jnp.where(is_hop, counted - 1, frames)
    number = jnp.arange(frames, dtype=jnp.int32)[:, None]
    lane = jnp.arange(lanes, dtype=jnp.int32)[None]
    frame = jnp.full((frames, lanes), frames - 1, jnp.int32)
    frame = frame.at[row, lane].set(jnp.broadcast_to(number, (frames, lanes)), mode="drop")
    count = counted[-1]
    is_row = number < count[None]

    def table(recorded: AnyArray) -> jax.Array:
        return jnp.where(is_row, jnp.take_along_axis(recorded, frame, axis=0), jnp.nan)

    return Hops(
        time_s=table(trajectory.apex_time_s),
        height_m=table(trajectory.apex_height_m),
        phase_rad=table(trajectory.apex_phase_rad % (2.0 * jnp.pi)),
        frame=frame,
        n_hops=count,
    )
