"""One rollout for people: the trajectory, its apexes, its efficiency."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M, MOST_RAD_PER_S, require_within
from tegotae.measures.hopping.hopping import dies_out, whole_hops
from tegotae.measures.hopping.signals import check_work, cot_inverse, work_total
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Hopper, require_one_limb
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.rollout import (
    Engine,
    Scenario,
    Timing,
    Trajectory,
)

_MOST = {
    "omega": MOST_RAD_PER_S,
    "height_m": MOST_M,
    "velocity_m_per_s": MOST_M,
    "drop_m": MOST_M,
}
"""How large entries of a scenario may be, either way."""


EFFICIENCY = (
    *("cot_inverse_flight", "cot_inverse_total"),
    *("climb_flight_m", "climb_total_m", "work_j", "window_s"),
)
"""What a summary has of whole hops: all null where none counts."""


@dataclass(frozen=True)
class Simulation:
    """A controller, its weights, and what it meets: all numbers of one lane.

    Args:
        controller: what drives the hopper.
        weights: shape [n_weights].
        scenario: frequency, release and ground.
        hopper: the body.
        timing: duration, control period, recording period.
        work: definition of work.
        measure_from_s: time from which on whole hops count for CoT⁻¹, with their work and climbs
            [s]; half of the duration by default.
        dtype: "float32" or "float64".

    Raises:
        TegotaeError: for numbers that are not finite or too large for `dtype`, a release without
            leg length, an unknown definition of work, or a window outside the rollout.

    Example:
        >>> from tegotae.systems.models import build
        >>> simulation = Simulation(build("V-reflex-w8"), np.array([2.0]), Scenario(omega=8.0))
        >>> result = simulation.run()
        >>> len(result.trajectory.height_m)
        1000
    """

    controller: Controller
    weights: np.ndarray
    scenario: Scenario
    hopper: Hopper = field(default_factory=Hopper)
    timing: Timing = field(default_factory=Timing)
    work: str = "absolute"
    measure_from_s: float | None = None
    dtype: str = "float32"
    integrator: Integrator = field(default_factory=PredictorCorrector)

    def __post_init__(self) -> None:
        require_one_limb(self.hopper, "a simulation for people")
        check_work(self.work)
        numbers = _numbers(self.scenario)
        if numbers["drop_time_s"] == math.inf:  # never
            del numbers["drop_time_s"]
        own = vars(self.hopper).items()
        numbers |= {name: x for name, x in own if isinstance(x, float) and x != math.inf}
        numbers |= {f"weight {i}": weight for i, weight in enumerate(self.weights)}
        for name, value in numbers.items():
            require_within(name, value, _MOST.get(name, float(np.finfo(self.dtype).max)))
        require_finite("height_m", self.scenario.height_m, above=0.0)
        duration_s = self.timing.duration_s
        require_finite("measure_from_s", self.measured_from_s, least=0.0)
        if self.measured_from_s >= duration_s:
            raise TegotaeError(
                f"the measuring window begins at {self.measured_from_s:g} s, but the rollout ends "
                f"at {duration_s:g} s; let it begin before that"
            )

    @property
    def measured_from_s(self) -> float:
        """Where the measuring window begins [s]."""
        start = self.measure_from_s
        return self.timing.duration_s / 2 if start is None else start

    def run(self) -> Result:
        """Simulate.

        Raises:
            TegotaeError: for weights of the wrong number, or a tick too long for the hopper.
        """
        engine = Engine(controller=self.controller, timing=self.timing, integrator=self.integrator)
        # Wrapped here, in double precision: float32 holds few digits of a large phase.
        scenario = self.scenario._replace(phase_rad=self.scenario.phase_rad % math.tau)
        lanes = engine.run(self.weights, scenario, self.hopper, dtype=self.dtype)
        return Result(self, jax.tree.map(_first_lane, lanes))


def _first_lane(recorded: AnyArray) -> AnyArray:
    return recorded[..., 0]


@dataclass(frozen=True)
class Result:
    """The result: the trajectory of one lane (arrays of shape [frames]) and its summary."""

    simulation: Simulation
    trajectory: Trajectory

    @property
    def apexes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times [s], heights [m] and phases [rad] of the flight apexes."""
        t = self.trajectory
        at = ~np.isnan(t.apex_time_s)
        return t.apex_time_s[at], t.apex_height_m[at], t.apex_phase_rad[at]

    def summary(self) -> JsonObject:
        """The result as JSON values; null for what is not finite, or undefined after a failure."""
        t, failed = self.trajectory, bool(self.trajectory.failed[-1])
        times, heights, phases = self.apexes
        return as_json(
            {
                "apex_time_s": times,
                "apex_height_m": heights,
                "apex_phase_rad": phases,
                **self._efficiency(),
                "work": self.simulation.work,
                "failed": failed,
                "failed_time_s": t.time_s[np.argmax(t.failed)] if failed else None,
            }
        )

    def _efficiency(self) -> JsonObject:
        """Climbs and work over the whole hops that count, as in training; null with the reason."""
        t, simulation = self.trajectory, self.simulation
        timing = simulation.timing
        first = min(round(simulation.measured_from_s / timing.frame_s), timing.n_frames - 1)
        rest_length_m = simulation.hopper.rest_length_m
        hops = whole_hops(t.apex_height_m[first:], t.ground_m[first:], rest_length_m)
        begins, ends = (first + int(frame) for frame in (hops.begins, hops.ends))
        reason = self._no_efficiency(int(hops.n_hops), float(t.apex_time_s[ends]))
        if reason is not None:
            return dict.fromkeys(EFFICIENCY, None) | {"hops": 0, "reason": reason}
        totals = (t.climb_flight_m, t.climb_m, work_total(t, simulation.work))
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
        """Why there is no CoT⁻¹, if there is none."""
        start_s, body = self.simulation.measured_from_s, self.simulation.hopper
        if self.trajectory.failed[-1]:
            return "the rollout failed"
        if hops < 0:
            weak = f"; it pushes with {body.max_force_n:g} N and weighs {body.weight_n:g} N"
            return f"no hop from {start_s:g} s on" + weak * bool(body.max_force_n <= body.weight_n)
        if dies_out(last_hop_s, self.simulation.timing.duration_s):
            return f"no hop after {last_hop_s:.1f} s"
        if hops == 0:
            return f"one hop from {start_s:g} s on; it takes a whole one, from apex to apex"
        return None


def _numbers(scenario: Scenario) -> dict[str, Any]:
    """A scenario's numbers by name, those of its pose and oscillator among them."""
    entries = scenario._asdict()
    del entries["changes"]
    return {**dict(entries.pop("initial_pose")), **dict(entries.pop("oscillator_state")), **entries}
