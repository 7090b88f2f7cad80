"""Retention of a gait under a disturbance: of one leg its hops, of several their lags."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.gaits.lags import lag_difference
from tegotae.measures.gaits.names import HEADING, speed_ahead_m_per_s
from tegotae.measures.gaits.summary import Coordination, CoordinationSummary
from tegotae.measures.hopping.hopping import LimitCycle, dies_out, find_limit_cycle, hops
from tegotae.measures.hopping.signals import cot_inverse
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.summaries import KeptChannels, Summary

EVENT_SHARE = 0.375
"""Share of the time after which what happens at a time happens: the first apex then, of what
hops."""
_LAG_TOLERANCE = 0.1
"""Largest distance of a gait's lags from those without a disturbance [cycles]."""
MEASURED_SHARE = 0.375
"""Efficiency is that of the whole hops in this last share of the time."""
STANDING_SHARE = 0.25
"""Share of its undisturbed speed above which a walker still walks."""

_CHANNELS = (
    *("time_s", "ground_m", "failed", "apex_time_s", "apex_height_m", "apex_phase_rad"),
    *("work_absolute_j", "climb_flight_m"),
)

Outcomes: TypeAlias = Mapping[str, np.ndarray]
"""Outcomes of rollouts, by name, arrays [..., lanes]."""


def retained(
    had: np.ndarray,
    moved: np.ndarray,
    moves: np.ndarray,
    keeps: np.ndarray,
    efficiency: np.ndarray,
    speed: np.ndarray | float = np.nan,
) -> dict[str, np.ndarray]:
    """Return the retained gaits under disturbances (`Retention`), [levels, lanes] each.

    Args:
        had: whether there was a gait without them, [lanes].
        moved: whether there was motion without them, [lanes].
        moves: whether there still is, [levels, lanes].
        keeps: whether the gait is the same.
        efficiency: over that without them; of what does not move it is not defined.
        speed: likewise.
    """
    baseline = {
        name: np.broadcast_to(x, moves.shape) for name, x in (("had", had), ("moved", moved))
    }
    shares = {"efficiency": efficiency, "speed": speed}
    disturbed = {name: np.where(moves, x, np.nan) for name, x in shares.items()}
    return {**baseline, "moves": moves, "keeps": keeps, **disturbed}


@dataclass(frozen=True)
class HopRetention:
    """One leg: it hops while it has not failed and its last hops are not long ago; its gait is a
    limit cycle that lasts until the end, and is the same if it has as many hops.

    Args:
        rest_length_path: what the leg's length is called in a scenario's changes.
        rest_length_m: as it usually is.
        event_s: after which time the next apex is that of the disturbance [s].

    Heights are near where they are within 0.5 % of that length.
    """

    rest_length_path: str
    rest_length_m: float
    event_s: float

    summary = KeptChannels(_CHANNELS)

    def outcomes(self, recorded: Trajectory, scenario: Scenario) -> dict[str, AnyArray]:
        """Return the outcomes of recorded rollouts, arrays [..., lanes]."""
        length = dict(scenario.changes).get(self.rest_length_path, np.float32(self.rest_length_m))
        limit_cycle = LimitCycle()
        near = dataclasses.replace(
            limit_cycle, height_tolerance_m=limit_cycle.height_tolerance_m * self.rest_length_m
        )
        return _hop_measures(
            near, recorded, jnp.asarray(length), jnp.asarray(self.event_s, "float32")
        )

    def at_s(self, baseline: Outcomes) -> np.ndarray:
        """Return the time of a hop's next apex; for a body that hops no more, the time itself."""
        apex = np.asarray(baseline["apex_s"])
        return np.where(np.isfinite(apex), apex, self.event_s)

    def shares_kept(
        self, baseline: Outcomes, disturbed: Outcomes, weight_ratio: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the retained part under a disturbance (`Retention`), [levels, lanes] each.

        Efficiency is the dimensionless CoT⁻¹, m g Σh / E.

        Args:
            baseline: without it, [1, lanes].
            disturbed: with it, [levels, lanes].
            weight_ratio: weight of the body over the usual one.
        """
        had = np.isfinite(baseline["period"])
        keeps = disturbed["hops"] & (disturbed["period"] == baseline["period"])
        moves = disturbed["hops"] & baseline["hops"]
        with np.errstate(invalid="ignore", divide="ignore"):
            efficiency = disturbed["cot_inverse"] * weight_ratio / baseline["cot_inverse"]
        return retained(had, baseline["hops"], moves, keeps & had, efficiency)


@partial(jax.jit, static_argnums=0)
def _hop_measures(
    near: LimitCycle, recorded: Trajectory, rest_length_m: Numeric, event_s: Numeric
) -> dict[str, AnyArray]:
    table = hops(recorded, rest_length_m)
    end_s = recorded.time_s[-1]
    cycle = find_limit_cycle(table, near, -jnp.inf, end_s)
    last_s = jnp.max(jnp.where(jnp.isnan(table.time_s), -jnp.inf, table.time_s), axis=0)

    # The last hops, an even number of them, whatever they are: noise leaves no limit cycle.
    last = table.n_hops - 1
    first = jnp.sum(table.time_s < (1.0 - MEASURED_SHARE) * end_s[None], axis=0, dtype=jnp.int32)
    first = jnp.clip(first + (last - first) % 2, 0, jnp.maximum(last, 0))

    sound = ~recorded.failed[-1]
    on_cycle = cycle.found & sound
    totals = recorded.climb_flight_m, recorded.work_absolute_j
    climbed, work = (table.between(first, jnp.maximum(last, 0), total) for total in totals)
    gained = jnp.where(last > first, cot_inverse(climbed, work), jnp.nan)
    later = jnp.where(table.time_s >= event_s, table.time_s, jnp.inf)
    return {
        "hops": sound & ~dies_out(last_s, end_s),
        "period": jnp.where(on_cycle, cycle.period, jnp.nan),
        "cot_inverse": jnp.where(sound, gained, jnp.nan),
        "apex_s": jnp.min(later, axis=0),
    }


@dataclass(frozen=True, kw_only=True)
class Walked(CoordinationSummary):
    """An engine's summary: the `Coordination` of every lane, and its speed ahead [m/s].

    Args:
        looks: whether the body knows where it looks; else the speed is that over ground.
    """

    looks: bool

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that are recorded for it."""
        return tuple(dict.fromkeys((*super().needs, *(HEADING if self.looks else ()))))

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[Coordination, AnyArray]:
        """Summarise the last quarter of every lane."""
        summary = super().__call__(trajectory, scenario, body, timing)
        if not self.looks:
            return summary, summary.speed_m_per_s
        frames = len(trajectory.time_s)
        return summary, speed_ahead_m_per_s(trajectory, frames - max(frames // 4, 2))


@dataclass(frozen=True)
class GaitRetention:
    """Several legs: they walk while they have not fallen, some leg steps, and they come ahead at a
    quarter of their speed at least, the way they usually go; their gait is lags that are locked,
    and is the same if those are.

    Args:
        summary: of the coordination of the legs, and of their speed.
        event_s: when a disturbance comes [s].
    """

    summary: Summary
    event_s: float

    def outcomes(
        self, recorded: tuple[Coordination, AnyArray], scenario: Scenario
    ) -> dict[str, AnyArray]:
        """Return the outcomes of recorded rollouts, arrays [..., lanes]."""
        legs, ahead = recorded
        names = ("lag", "lock_time_s", "fall_time_s", "cost_of_transport", "step_frequency_hz")
        return {name: getattr(legs, name) for name in names} | {"ahead_m_per_s": ahead}

    def at_s(self, baseline: Outcomes) -> np.ndarray:
        """Return the time of a disturbance [s], [lanes], from the undisturbed outcomes."""
        return np.full(baseline["fall_time_s"].shape, self.event_s)

    def shares_kept(
        self, baseline: Outcomes, disturbed: Outcomes, weight_ratio: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the retained part of a gait; efficiency is the inverse cost of transport."""
        with np.errstate(invalid="ignore", divide="ignore"):
            locked = np.isfinite(baseline["lock_time_s"])
            gap = np.asarray(lag_difference(disturbed["lag"], baseline["lag"]))
            near = np.nanmax(np.where(np.isnan(gap), np.inf, gap), axis=0) <= _LAG_TOLERANCE
            speed = disturbed["ahead_m_per_s"] / baseline["ahead_m_per_s"]
            moved = _steps(baseline)
            moves = moved & _steps(disturbed) & ~(speed < STANDING_SHARE)
            efficiency = baseline["cost_of_transport"] / disturbed["cost_of_transport"]
        keeps = moves & locked & near & np.isfinite(disturbed["lock_time_s"])
        return retained(locked, moved, moves, keeps, efficiency, speed)


def _steps(outcomes: Outcomes) -> np.ndarray:
    """Return a mask of the lanes that stand and step with any leg, since any leg may be lost."""
    return np.isnan(outcomes["fall_time_s"]) & (outcomes["step_frequency_hz"] > 0.0).any(axis=0)
