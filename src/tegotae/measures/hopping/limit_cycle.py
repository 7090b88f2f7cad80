"""Limit cycles: from which hop on a gait repeats itself, and after how many hops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.measures.hopping.hopping import Hops
from tegotae.parts._shapes import AnyArray, Numeric

_LATEST = 1.1  # of the time to the next hop, when it would have come


@dataclass(frozen=True, kw_only=True)
class LimitCycle:
    """When a gait counts as settled on a limit cycle.

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

    height_tolerance_m: float = 0.005
    phase_tolerance_rad: float = 0.05
    max_period: int = 4
    min_repeats: int = 4

    def __post_init__(self) -> None:
        require_finite("height_tolerance_m", self.height_tolerance_m, above=0.0)
        if math.isnan(self.phase_tolerance_rad) or self.phase_tolerance_rad <= 0.0:
            raise TegotaeError(
                f"phase_tolerance_rad is {self.phase_tolerance_rad}; it must be greater than 0 "
                "(infinite to leave the phase out)"
            )
        require_count("max_period", self.max_period)
        require_count("min_repeats", self.min_repeats)


class Settled(NamedTuple):
    """From where on each lane is on its limit cycle: arrays of shape [lanes]."""

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


def settled(hops: Hops, settings: LimitCycle, start_s: Numeric, end_s: Numeric) -> Settled:
    """Where the gait settles on a limit cycle that lasts until the end of a window.

    A body that stops hopping before the end has no limit cycle.

    Args:
        hops: the table of hops, shape [rows, lanes].
        settings: tolerances, longest period, repeats.
        start_s: where the window starts [s]: only later hops count; a number or [lanes].
        end_s: where the window ends [s]; a number or [lanes].
    """
    rows, lanes = hops.time_s.shape
    start_s, end_s = (
        jnp.broadcast_to(jnp.asarray(at, hops.time_s.dtype), (lanes,)) for at in (start_s, end_s)
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
            apart = jnp.abs((phase - counterpart(phase) + jnp.pi) % (2.0 * jnp.pi) - jnp.pi)
            close &= apart <= settings.phase_tolerance_rad
        first_far = jnp.argmin(close, axis=0).astype(jnp.int32)
        repeats = jnp.where(close.all(axis=0), rows, first_far)
        # The last hop ends a cycle: the next is as far off as the first of that cycle was.
        hops_on = end_s - time[0] <= _LATEST * (time[k - 1] - time[k])
        is_cycle = (repeats >= k * (settings.min_repeats + 1)) & hops_on
        period = jnp.where(is_cycle, float(k), period)
        run = jnp.where(is_cycle, repeats, run)
    found = jnp.isfinite(period)
    part_of_cycle = (run - 1) % jnp.where(found, period, 1.0).astype(run.dtype)
    steps = jnp.where(found, run - 1 - part_of_cycle, 0)
    first_settled = jnp.take_along_axis(time, jnp.maximum(run - 1, 0)[None], axis=0)[0]
    return Settled(
        period=period,
        time_s=jnp.where(found, first_settled, jnp.nan),
        from_hop=jnp.where(found, last - steps, 0),
        to_hop=jnp.where(found, last, 0),
    )
