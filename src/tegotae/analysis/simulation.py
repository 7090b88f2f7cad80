"""One rollout for people: the trajectory, its apexes, its efficiency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M, require_within
from tegotae.measures.hopping.hopping import dies_out, hop_height_m, whole_hops
from tegotae.measures.hopping.signals import cot_inverse, work_total
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body, require_one_limb
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Timing
from tegotae.systems.system import System

EFFICIENCY = (
    *("cot_inverse_flight", "cot_inverse_total"),
    *("climb_flight_m", "climb_total_m", "work_j", "window_s"),
)
"""Entries of a summary about whole hops: all null where none counts."""


@dataclass(frozen=True)
class Result:
    """One rollout of a system with one leg: arrays of shape [frames], and their summary."""

    system: System
    timing: Timing
    """Duration, control period, recording period."""
    trajectory: Trajectory
    work: str
    """Definition of work."""
    measure_from_s: float
    """Time from which on whole hops count for CoT⁻¹, with their work and climbs [s]."""

    @property
    def body(self) -> Body:
        """The body that moved."""
        return self.system.mechanics

    @property
    def apexes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times [s], heights [m] and phases [rad] of the flight apexes."""
        t = self.trajectory
        mask = ~np.isnan(t.apex_time_s)
        return t.apex_time_s[mask], t.apex_height_m[mask], t.apex_phase_rad[mask]

    def summary(self) -> JsonObject:
        """Return the result as JSON values; null for a number that is not finite, or undefined
        after a failure.
        """
        t, failed = self.trajectory, bool(self.trajectory.failed[-1])
        times, heights, phases = self.apexes
        return as_json(
            {
                "apex_time_s": times,
                "apex_height_m": heights,
                "apex_phase_rad": phases,
                **self._efficiency(),
                "work": self.work,
                "failed": failed,
                "failed_time_s": t.time_s[np.argmax(t.failed)] if failed else None,
            }
        )

    def _efficiency(self) -> JsonObject:
        """Return climbs and work over the whole hops that count, as in training; null with the
        reason.
        """
        t, timing = self.trajectory, self.timing
        first = min(round(self.measure_from_s / timing.frame_s), timing.n_frames - 1)
        hops = whole_hops(t.apex_height_m[first:], t.ground_m[first:], self.body.rest_length_m)
        begins, ends = (first + int(frame) for frame in (hops.begins, hops.ends))
        reason = self._no_efficiency(int(hops.n_hops), float(t.apex_time_s[ends]))
        if reason is not None:
            return dict.fromkeys(EFFICIENCY, None) | {"hops": 0, "reason": reason}
        totals = (t.climb_flight_m, t.climb_m, work_total(t, self.work))
        flight, climb, work_j = (float(total[ends] - total[begins]) for total in totals)
        return {
            "cot_inverse_flight": float(cot_inverse(flight, work_j)),
            "cot_inverse_total": float(cot_inverse(climb, work_j)),
            "climb_flight_m": flight,
            "climb_total_m": climb,
            "work_j": work_j,
            "window_s": [t.apex_time_s[begins], t.apex_time_s[ends]],
            "hops": int(hops.n_hops),
            "reason": None,
        }

    def _no_efficiency(self, hops: int, last_hop_s: float) -> str | None:
        """Return the reason why there is no CoT⁻¹; None if there is one."""
        start_s, body = self.measure_from_s, self.body
        if self.trajectory.failed[-1]:
            return "the rollout failed"
        if hops < 0:
            weight_n = getattr(body, "weight_n", math.nan)
            weak = f"; it pushes with {body.max_force_n:g} N and weighs {weight_n:g} N"
            return f"no hop from {start_s:g} s on" + weak * bool(body.max_force_n <= weight_n)
        if dies_out(last_hop_s, self.timing.duration_s):
            return f"no hop after {last_hop_s:.1f} s"
        if hops == 0:
            return f"one hop from {start_s:g} s on; it takes a whole one, from apex to apex"
        return None


def largest_change_m(apexes_m: np.ndarray, others_m: np.ndarray, rest_length_m: float) -> float:
    """Return the largest difference between the nth hops' apexes of two rollouts [m]; infinite if
    hops were lost or added.

    A last hop that only one of them reaches does not count: errors in time make a rollout end just
    before a hop that the other has.

    Args:
        apexes_m: heights of apexes in the order of time [m]; NaN stands for none.
        others_m: those of the other rollout, such as one at half the control period.
        rest_length_m: rest length of the leg, from which a hop is told from a bounce [m].

    Example:
        >>> float(round(largest_change_m(np.array([1.2, 1.3]), np.array([1.2, 1.29, 1.3]), 1.0), 4))
        0.01
    """
    lowest_m = hop_height_m(rest_length_m)
    first, second = (heights[heights >= lowest_m] for heights in (apexes_m, others_m))
    count = min(len(first), len(second))
    if max(len(first), len(second)) > count + 1:
        return math.inf
    return float(np.abs(first[:count] - second[:count]).max(initial=0.0))


def simulate(
    system: System,
    weights: ArrayLike,
    timing: Timing | None = None,
    *,
    drop_m: float = 0.0,
    drop_time_s: float = math.inf,
    work: str = "absolute",
    measure_from_s: float | None = None,
    dtype: str = "float32",
) -> Result:
    """Roll out a system with one leg.

    Args:
        system: the closed loop.
        weights: shape [n_weights].
        timing: duration, control period, recording period; 20 s by default.
        drop_m: height by which the ground drops [m].
        drop_time_s: when it drops [s].
        work: definition of work.
        measure_from_s: time from which on whole hops count for CoT⁻¹, with their work and climbs
            [s]; half of the duration by default.
        dtype: "float32" or "float64".

    Raises:
        TegotaeError: for a body of several limbs, numbers that are too large for `dtype`, weights
            of the wrong number, a window outside the rollout, or a tick too long for the body.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> system = System(controller=recipe("V-reflex-w8").controller(), omega=8.0)
        >>> len(simulate(system, [2.0]).trajectory.height_m)
        1000
    """
    timing, body = timing or Timing(), system.mechanics
    require_one_limb(body, "a simulation for people")
    body.check_tick(timing.tick_s)
    require_within("drop_m", drop_m, MOST_M)
    require_within("velocity_m_per_s", system.release.velocity_m_per_s, MOST_M)
    numbers = {name: x for name, x in vars(body).items() if isinstance(x, float) and x != math.inf}
    numbers |= {f"weight {i}": weight for i, weight in enumerate(np.ravel(weights))}
    for name, value in numbers.items():
        require_within(name, value, float(np.finfo(dtype).max))
    start_s = timing.duration_s / 2 if measure_from_s is None else measure_from_s
    require_finite("measure_from_s", start_s, least=0.0)
    if start_s >= timing.duration_s:
        raise TegotaeError(
            f"the measuring window begins at {start_s:g} s, but the rollout ends "
            f"at {timing.duration_s:g} s; let it begin before that"
        )
    scenario = system.scenario(drop_m=drop_m, drop_time_s=drop_time_s)
    # Wrapped here, in double precision: float32 holds few digits of a large phase.
    scenario = scenario._replace(phase_rad=scenario.phase_rad % math.tau)
    lanes = system.rollout(timing=timing).run(weights, scenario, body, dtype=dtype)
    return Result(system, timing, jax.tree.map(_first_lane, lanes), work, start_s)


def _first_lane(recorded: AnyArray) -> AnyArray:
    return recorded[..., 0]
