"""The package's own engine, timed and weighed."""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

from tegotae.controller import Controller
from tegotae.models import build
from tegotae.rollout import Engine, Scenario, Timing


def controller() -> Controller:
    """The ART controller of the benchmark: 96 weights."""
    return build("ART")


def totals(trajectory, scenario, body, timing):
    """What a fitness needs at least: totals over the rollout."""
    return trajectory.climb_flight_m[-1], trajectory.work_absolute_j[-1], trajectory.failed[-1]


def weights(lanes: int) -> np.ndarray:
    """Random weights, shape [lanes, n_weights]."""
    return np.random.default_rng(0).normal(size=(lanes, controller().n_weights)) * 0.5


def ticks_per_second(lanes: int = 1024, duration_s: float = 10.0) -> tuple[float, float]:
    """Control ticks per second and seconds to compile; the best of three runs."""
    timing = Timing(duration_s=duration_s)
    engine = Engine(controller=controller(), timing=timing, summary=totals)
    lanes_weights = weights(lanes)
    times = []
    for _ in range(4):
        begun = time.perf_counter()
        engine.run(lanes_weights, Scenario(omega=5.0))
        times.append(time.perf_counter() - begun)
    ticks = timing.n_frames * timing.ticks_per_frame
    return lanes * ticks / min(times[1:]), times[0] - min(times[1:])


def peak_memory_gib(lanes: int = 100_000, duration_s: float = 20.0) -> float:
    """Largest memory of this process [GiB] after so many lanes of so many seconds."""
    engine = Engine(controller=controller(), timing=Timing(duration_s=duration_s), summary=totals)
    engine.run(weights(lanes), Scenario(omega=5.0))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**30 if sys.platform == "darwin" else 2**20)


if __name__ == "__main__":
    # A number of lanes: their speed. None: the memory of very many.
    print(ticks_per_second(int(sys.argv[1]))[0] if len(sys.argv) > 1 else peak_memory_gib())
