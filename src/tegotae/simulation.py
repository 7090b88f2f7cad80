"""One rollout for people: the trajectory, its apexes, its efficiency."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tegotae.bodies import Hopper
from tegotae.controller import Controller
from tegotae.errors import TegotaeError, require_finite
from tegotae.integrators import Integrator, PredictorCorrector
from tegotae.metrics.efficiency import cot_inverse, work_total
from tegotae.rollout import Engine, Scenario, Timing, Trajectory


@dataclass(frozen=True)
class Simulation:
    """A controller, its weights, and what it meets: all numbers of one lane.

    Args:
        controller: what drives the hopper.
        weights: shape [n_weights].
        scenario: frequency, release and ground.
        hopper: the body.
        timing: duration, control period, recording period.
        energy: definition of work.
        measure_from_s: where the window begins over which work and climbs are counted [s];
            half of the duration by default. It ends with the rollout.
        dtype: "float32" or "float64".
    """

    controller: Controller
    weights: np.ndarray
    scenario: Scenario
    hopper: Hopper = field(default_factory=Hopper)
    timing: Timing = field(default_factory=Timing)
    energy: str = "absolute"
    measure_from_s: float | None = None
    dtype: str = "float32"
    integrator: Integrator = field(default_factory=PredictorCorrector)

    def run(self) -> Result:
        """Simulate.

        Raises:
            TegotaeError: for a window outside the rollout, or a non-finite scenario.
        """
        start = self.timing.duration_s / 2 if self.measure_from_s is None else self.measure_from_s
        require_finite("measure_from", start, least=0.0)
        if start >= self.timing.duration_s:
            raise TegotaeError(
                f"the measuring window begins at {start:g} s, after the end of the rollout at "
                f"{self.timing.duration_s:g} s"
            )
        for name, value in self.scenario._asdict().items():
            if name != "drop_time_s":
                require_finite(name, value)
        engine = Engine(controller=self.controller, timing=self.timing, integrator=self.integrator)
        lanes = engine.run(self.weights, self.scenario, self.hopper, dtype=self.dtype)
        trajectory = Trajectory(*(entry[:, 0] for entry in lanes))
        return Result(self, trajectory, float(start))


@dataclass(frozen=True)
class Result:
    """What came out: the trajectory of one lane (arrays of shape [frames]) and its summary."""

    simulation: Simulation
    trajectory: Trajectory
    measured_from_s: float

    @property
    def apexes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times [s], heights [m] and phases [rad] of the flight apexes."""
        t = self.trajectory
        at = ~np.isnan(t.apex_time_s)
        return t.apex_time_s[at], t.apex_height_m[at], t.apex_phase_rad[at]

    def summary(self) -> dict[str, Any]:
        """The result as JSON values."""
        t, simulation = self.trajectory, self.simulation
        timing = simulation.timing
        first = min(round(self.measured_from_s / timing.frame_s), timing.n_frames - 1)

        def over_window(total: np.ndarray) -> float:
            return float(total[-1] - (total[first - 1] if first else 0.0))

        work = over_window(work_total(t, simulation.energy))
        flight, total = over_window(t.climb_flight_m), over_window(t.climb_m)
        times, heights, phases = self.apexes
        failed = bool(t.failed[-1])
        return {
            "apex_time_s": times.astype(float).tolist(),
            "apex_height_m": heights.astype(float).tolist(),
            "apex_phase_rad": phases.astype(float).tolist(),
            "cot_inverse_flight": None if failed else float(cot_inverse(flight, work)),
            "cot_inverse_total": None if failed else float(cot_inverse(total, work)),
            "climb_flight_m": flight,
            "climb_total_m": total,
            "work_j": work,
            "energy": simulation.energy,
            "window_s": [first * timing.frame_s, timing.n_frames * timing.frame_s],
            "failed": failed,
            "failed_time_s": float(t.time_s[np.argmax(t.failed)]) if failed else None,
        }
