"""Definition of hopping: hops, the Poincaré section at the apex, and limit cycles on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.parameters import Part, positive, whole
from tegotae.simulation.recorder import Trajectory

HOP_CLEARANCE = 0.01
"""A hop clears the rest length of the leg by at least this share of it.

A constant push leaves a damped leg bouncing on the spot of touchdown, ever lower but for ever:
such a bounce is no hop.
"""


def hop_height_m(rest_length_m: Numeric, ground_m: Numeric = 0.0) -> Numeric:
    """Return the least height of a hop's apex, `(1 + 0.01) l0 + h` [m].

    Args:
        rest_length_m: rest length of the leg l0 [m].
        ground_m: height of the ground h [m].
    """
    return (1.0 + HOP_CLEARANCE) * rest_length_m + ground_m


REST_SHARE = 0.25
"""A body that makes no hop in this last share of its time rests."""


def dies_out(last_hop_s: Numeric, duration_s: Numeric) -> AnyArray | np.bool | bool:
    """Return whether a gait is over: no hop in the last quarter of the time since the release.

    Args:
        last_hop_s: time of the last apex of a hop [s], any shape; minus infinity without one.
        duration_s: the time that it is looked at, from the release on [s].

    Example:
        >>> bool(dies_out(14.0, 20.0)), bool(dies_out(16.0, 20.0))
        (True, False)
    """
    return last_hop_s < (1.0 - REST_SHARE) * duration_s


def left_out(count: AnyArray) -> jax.Array:
    """Return the number of whole hops omitted at the beginning: one of an odd number of three or
    more.

    So a gait that alternates between two hops is credited for both alike.

    Args:
        count: number of whole hops, any shape.

    Example:
        >>> left_out(jnp.arange(6)).tolist()
        [0, 0, 0, 1, 0, 1]
    """
    return jnp.where((count > 2) & (count % 2 == 1), 1, 0)


class WholeHops(NamedTuple):
    """Whole hops, from apex to apex, over which CoT⁻¹ is taken.

    At an apex nothing is climbed and no work is done, so that totals at the end of the apex's frame
    are those at the apex. Any other window counts climbs and work of a piece of a hop.
    """

    begins: AnyArray
    """The frame of the first apex, shape [lanes]; the last frame without a hop."""
    ends: AnyArray
    """The frame of the last apex, [lanes]; the last frame without a hop."""
    n_hops: AnyArray
    """Number of whole hops between the two, [lanes]; -1 without an apex."""

    def over(self, total: AnyArray) -> jax.Array:
        """Return the growth of a running total [frames, lanes] over the whole hops, [lanes]; 0
        without any."""
        grown = at_frame(total, self.ends) - at_frame(total, self.begins)
        return jnp.where(self.n_hops > 0, grown, 0.0)


def at_frame(recorded: AnyArray, frame: AnyArray) -> jax.Array:
    """Return the values [lanes] of a recording [frames, lanes] at one frame of each lane
    [lanes].
    """
    return jnp.take_along_axis(jnp.asarray(recorded), frame[None], axis=0)[0]


def whole_hops(apex_height_m: AnyArray, ground_m: Numeric, rest_length_m: Numeric) -> WholeHops:
    """Return the last whole hops of some frames: all of one or two, an even number of three or
    more.

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
    """Number of hops of the lane, shape [lanes]."""

    def between(self, first: AnyArray, last: AnyArray, total: AnyArray) -> jax.Array:
        """Return the growth of a running total [frames, lanes] from hop to hop, each [lanes].

        They go from apex to apex, in whole frames.
        """
        ends, begins = (at_frame(total, at_frame(self.frame, hop)) for hop in (last, first))
        return ends - begins


def hops(trajectory: Trajectory, rest_length_m: Numeric) -> Hops:
    """Return the hops of a trajectory: flights whose apex clears the rest length by 1 % of it.

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
    lowest = hop_height_m(rest_length_m, trajectory.ground_m)
    # NaN in frames without an apex compares as false.
    is_hop = jnp.asarray(trajectory.apex_height_m >= lowest)
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


_LATEST = 1.1  # of the time to the next hop, when it would have come


@dataclass(frozen=True, kw_only=True)
class LimitCycle(Part):
    """Criteria of a settled limit cycle.

    On the Poincaré section at the apex, with hops i = 1 ... N in the window, a gait is settled with
    period k from hop n on if every later hop lies close to its counterpart j in the last k hops,

        |y_i - y_j| <= height_tolerance_m  and  |φ_i - φ_j| (mod 2π) <= phase_tolerance_rad,
        j = N - (N - i) mod k,

    for all i = n ... N. The last cycle is the reference, not the hop before: a slow drift does not
    pass as a cycle however small its steps. Of all k up to `max_period` that hold for the last
    cycle and at least `min_repeats` before it, the smallest counts.

    Four repeats are also what the spectrum needs to separate the harmonics of the cycle.

    Args:
        height_tolerance_m: tolerance of the apex height [m].
        phase_tolerance_rad: tolerance of the phase at the apex [rad]; infinite to look at the body
            alone.
        max_period: longest period k [hops].
        min_repeats: how often the last cycle must be seen before itself.

    Raises:
        TegotaeError: for a tolerance that is not positive, or a count below 1.

    Example:
        >>> LimitCycle(max_period=2).max_period
        2
    """

    height_tolerance_m: float = positive(0.005)
    phase_tolerance_rad: float = 0.05
    max_period: int = whole(4)
    min_repeats: int = whole(4)

    def __post_init__(self) -> None:
        super().__post_init__()
        if math.isnan(self.phase_tolerance_rad) or self.phase_tolerance_rad <= 0.0:
            raise TegotaeError(
                f"phase_tolerance_rad is {self.phase_tolerance_rad}; it must be greater than 0 "
                "(infinite to leave the phase out)"
            )


class Settled(NamedTuple):
    """Beginning of each lane's limit cycle: arrays of shape [lanes]."""

    period: AnyArray
    """Period k [hops]; NaN where there is no limit cycle."""
    time_s: AnyArray
    """Time of the first settled apex [s]; NaN where there is no limit cycle."""
    from_hop: AnyArray
    """Row of the first hop of the last whole cycles that are settled, in the table of hops."""
    to_hop: AnyArray
    """Row of the last hop: a whole number of cycles after `from_hop`."""

    @property
    def found(self) -> jax.Array:
        """True where there is a limit cycle."""
        return jnp.isfinite(self.period)


def find_limit_cycle(hops: Hops, settings: LimitCycle, start_s: Numeric, end_s: Numeric) -> Settled:
    """Find the limit cycle on which the gait remains until the end of a window.

    A body that stops hopping before the end has no limit cycle.

    Args:
        hops: the table of hops, shape [rows, lanes].
        settings: tolerances, longest period, repeats.
        start_s: where the window starts [s]: only later hops count; a number or [lanes].
        end_s: where the window ends [s]; a number or [lanes].
    """
    rows, lanes = hops.time_s.shape
    start_s, end_s = (
        jnp.broadcast_to(jnp.asarray(bound, hops.time_s.dtype), (lanes,))
        for bound in (start_s, end_s)
    )
    first = jnp.sum(hops.time_s <= start_s[None], axis=0, dtype=jnp.int32)
    last = jnp.sum(hops.time_s <= end_s[None], axis=0, dtype=jnp.int32) - 1
    back = jnp.arange(rows, dtype=jnp.int32)[:, None]
    inside = back <= (last - first)[None]

    def from_the_last(table: AnyArray) -> jax.Array:
        return jnp.take_along_axis(table, jnp.clip(last[None] - back, 0, rows - 1), axis=0)

    time, height, phase = map(from_the_last, (hops.time_s, hops.height_m, hops.phase_rad))
    period = jnp.full_like(time[0], jnp.nan)
    run = jnp.zeros_like(last)
    for k in range(min(settings.max_period, rows - 1), 0, -1):

        def counterpart(x: jax.Array, k: int = k) -> jax.Array:
            return jnp.tile(x[:k], (-(-rows // k), 1))[:rows]

        close = inside & (jnp.abs(height - counterpart(height)) <= settings.height_tolerance_m)
        if math.isfinite(settings.phase_tolerance_rad):
            distance = jnp.abs((phase - counterpart(phase) + jnp.pi) % (2.0 * jnp.pi) - jnp.pi)
            close &= distance <= settings.phase_tolerance_rad
        first_far = jnp.argmin(close, axis=0).astype(jnp.int32)
        repeats = jnp.where(close.all(axis=0), rows, first_far)
        # The last hop ends a cycle: the next is as far off as the first of that cycle was.
        hops_on = end_s - time[0] <= _LATEST * (time[k - 1] - time[k])
        is_cycle = (repeats >= k * (settings.min_repeats + 1)) & hops_on
        period = jnp.where(is_cycle, float(k), period)
        run = jnp.where(is_cycle, repeats, run)
    exists = jnp.isfinite(period)
    part_of_cycle = (run - 1) % jnp.where(exists, period, 1.0).astype(run.dtype)
    steps = jnp.where(exists, run - 1 - part_of_cycle, 0)
    first_settled = at_frame(time, jnp.maximum(run - 1, 0))
    return Settled(
        period=period,
        time_s=jnp.where(exists, first_settled, jnp.nan),
        from_hop=jnp.where(exists, last - steps, 0),
        to_hop=jnp.where(exists, last, 0),
    )
