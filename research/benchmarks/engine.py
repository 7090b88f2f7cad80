"""The package's own engine, timed and weighed."""

from __future__ import annotations

import json
import resource
import sys
import time
from typing import NamedTuple

import numpy as np

from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe


def benchmark_controller() -> Controller:
    """Return the ART controller of the benchmark: 96 weights."""
    return recipe("ART").controller()


@needing("climb_flight_m", "work_absolute_j", "failed")
def totals(trajectory, scenario, body, timing):
    """Compute the minimum that a fitness needs: totals over the rollout."""
    return trajectory.climb_flight_m[-1], trajectory.work_absolute_j[-1], trajectory.failed[-1]


def weights(lanes: int) -> np.ndarray:
    """Return random weights, shape [lanes, n_weights]."""
    return np.random.default_rng(0).normal(size=(lanes, benchmark_controller().n_weights)) * 0.5


class Speed(NamedTuple):
    """Speed of an engine: the best of three runs."""

    ticks_per_s: float
    """Control ticks per second of time that passes."""
    ticks_per_core_s: float
    """Control ticks per second that a core is at work: the fairer figure on a machine in use."""
    compile_core_s: float
    """Core-seconds to trace, lower and compile the program."""


def engine_speed(lanes: int = 1024, duration_s: float = 10.0) -> Speed:
    """Measure the speed of this process's engine."""
    timing = Timing(duration_s=duration_s)
    rollout = Rollout(controller=benchmark_controller(), timing=timing, summary=totals)
    return timed(rollout, weights(lanes), Scenario(omega=5.0))


def timed(
    rollout: Rollout, weights: np.ndarray, scenario: Scenario, body: Body | None = None
) -> Speed:
    """Measure the speed of an engine with one lane per row of weights, on a body."""
    times, work = [], []
    for _ in range(4):
        begun, begun_work = time.perf_counter(), time.process_time()
        rollout.run(weights, scenario, body)
        times.append(time.perf_counter() - begun)
        work.append(time.process_time() - begun_work)
    ticks = len(weights) * rollout.timing.n_frames * rollout.timing.ticks_per_frame
    shortest = min(work[1:])
    return Speed(ticks / min(times[1:]), ticks / shortest, work[0] - shortest)


class LaneCost(NamedTuple):
    """Cost of a number of lanes."""

    lanes: int
    ticks_per_core_s: float
    """Control ticks per second that a core is at work, what is compiled included."""
    peak_gib: float
    """Largest memory of the process [GiB]."""


def cost(lanes: int, duration_s: float = 1.0) -> LaneCost:
    """Measure the cost of a number of lanes in a fresh process."""
    rollout = Rollout(
        controller=benchmark_controller(), timing=Timing(duration_s=duration_s), summary=totals
    )
    gains = np.asarray(weights(lanes), "float32")
    begun = time.process_time()
    rollout.run(gains, Scenario(omega=5.0))
    work = time.process_time() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    ticks = lanes * rollout.timing.n_frames * rollout.timing.ticks_per_frame
    return LaneCost(lanes, ticks / work, peak / (2**30 if sys.platform == "darwin" else 2**20))


if __name__ == "__main__":
    quantity, lanes = sys.argv[1], int(sys.argv[2])
    print(json.dumps({"speed": engine_speed, "cost": cost}[quantity](lanes)))
