"""What became of a rollout: its regime, its efficiency, and how phase and body keep step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.gait import FAILED, GaitSummary
from tegotae.measures.hopping.hopping import hops
from tegotae.measures.hopping.limit_cycle import settled
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.rollout import Scenario, Timing, Trajectory


class Outcome(NamedTuple):
    """What became of each rollout: arrays of one shape, NaN where undefined."""

    regime: AnyArray
    """Index into `tegotae.measures.hopping.gait.REGIMES`."""
    limit_cycle_period: AnyArray
    """Period k of the limit cycle [hops]."""
    cot_inverse: AnyArray
    """CoT⁻¹ A, of the heights climbed in flight [m/J]."""
    cot_inverse_total: AnyArray
    """CoT⁻¹ B, of all heights climbed [m/J]."""
    apex_height_m: AnyArray
    """Mean height of the apexes [m]."""
    hop_rate: AnyArray
    """Angular frequency of hopping, 2π / mean time between apexes [rad/s]."""
    phase_rate: AnyArray
    """Mean phase rate of the oscillator [rad/s]; zero without one."""

    @property
    def winding_ratio(self) -> AnyArray:
        """Revolutions of the oscillator per hop: mean phase rate over hopping frequency."""
        return self.phase_rate / self.hop_rate


def turn(phase_rad: AnyArray) -> AnyArray:
    """The same angle in [-π, π) [rad]."""
    return (phase_rad + 0.5 * TWO_PI) % TWO_PI - 0.5 * TWO_PI


@dataclass(frozen=True)
class OutcomeSummary:
    """The outcome of a rollout, as an `Engine`'s summary: an `Outcome` of arrays [lanes].

    Rates and apex height are means over the last whole limit cycles. Where nothing settles they are
    means from the first to the last hop in the second half of the rollout; where there are no two
    such hops, the phase rate is the mean over the second half and the others are undefined.

    Args:
        gait: how the gait is measured.

    Example:
        >>> import numpy as np
        >>> from tegotae import Engine, Scenario, build
        >>> engine = Engine(controller=build("V-reflex-w8"), summary=OutcomeSummary())
        >>> found = engine.run(np.array([[2.0]]), Scenario(omega=8.0))
        >>> f"{found.winding_ratio[0]:.3f} turns a hop"
        '1.000 turns a hop'
    """

    gait: GaitSummary = GaitSummary()  # noqa: RUF009 - immutable

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Outcome:
        """The outcome, each entry of shape [lanes]."""
        gait = self.gait(trajectory, scenario, body, timing)
        table = hops(trajectory, body.rest_length_m)
        end_s = trajectory.time_s[-1]
        middle = (timing.n_frames - 1) // 2
        cycle = settled(table, self.gait.limit_cycle, -jnp.inf, end_s)
        found = jnp.isfinite(gait.limit_cycle_period)
        final = jnp.maximum(table.n_hops - 1, 0)
        early = jnp.sum(table.time_s <= trajectory.time_s[middle][None], axis=0, dtype=final.dtype)
        first = jnp.where(found, cycle.from_hop.astype(final.dtype), jnp.minimum(early, final))
        last = jnp.where(found, cycle.to_hop.astype(final.dtype), final)
        number = (last - first).astype(end_s.dtype)

        travelled = unwrapped(trajectory.phase_rad)
        row = jnp.arange(timing.n_frames, dtype=last.dtype)[:, None]
        counts = (row > first[None]) & (row <= last[None])
        apex_height = jnp.sum(jnp.where(counts, table.height_m, 0.0), axis=0)

        def at(x: AnyArray, row: AnyArray) -> jax.Array:
            return jnp.take_along_axis(x, row[None], axis=0)[0]

        def travelled_at(hop: AnyArray) -> AnyArray:
            frame = at(table.frame, hop)
            since = turn(at(table.phase_rad, hop) - at(trajectory.phase_rad, frame))
            return at(travelled, frame) + since

        hopping = last > first
        lasted = jnp.where(hopping, at(table.time_s, last) - at(table.time_s, first), 1.0)
        over_hops = (travelled_at(last) - travelled_at(first)) / lasted
        over_half = (travelled[-1] - travelled[middle]) / (end_s - trajectory.time_s[middle])
        sound = gait.regime != FAILED
        return Outcome(
            regime=gait.regime,
            limit_cycle_period=gait.limit_cycle_period,
            cot_inverse=gait.cot_inverse,
            cot_inverse_total=gait.cot_inverse_total,
            apex_height_m=jnp.where(hopping & sound, apex_height / number, jnp.nan),
            hop_rate=jnp.where(hopping & sound, TWO_PI * number / lasted, jnp.nan),
            phase_rate=jnp.where(sound, jnp.where(hopping, over_hops, over_half), jnp.nan),
        )


def unwrapped(phase_rad: AnyArray) -> jax.Array:
    """A phase recorded modulo 2π as one that goes on [rad], shape [frames, lanes].

    Right as long as it moves by less than half a turn between frames.
    """
    steps = turn(jnp.diff(phase_rad, axis=0))
    return jnp.concatenate([phase_rad[:1], phase_rad[:1] + jnp.cumsum(steps, axis=0)])
