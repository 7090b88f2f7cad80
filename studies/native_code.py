"""What native code costs and gives: the table of docs/native.md.

    python studies/native_code.py

Each row is a program of lanes: core-seconds to trace it, to write it and to compile it, and control
ticks per core-second in blocks of one, two and three vectors. `tegotae bench` has XLA beside it.
The best of several runs that alternate; a machine in use by others varies by some percent.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, Shared
from tegotae.simulation.lanes import as_lanes

from tegotae import Engine, Scenario, Timing, build
from tegotae.lowering.episode import Kernel, TracedEpisode, compile_episode
from tegotae.parts.bodies import Bar, Body, Hopper, Plate, Walker
from tegotae.studies.benchmarks.legs import FOOT, OMEGA, WALKER_TICK_S

LANES = 1056
REPEATS = 5
NEEDS = ("climb_flight_m", "work_absolute_j", "failed")


def programs() -> dict[str, tuple[Engine, np.ndarray, Scenario, Body]]:
    """What is timed, by name."""
    rng = np.random.default_rng(0)
    sector = build("V-sector-w8")
    timing = Timing(duration_s=2.0)

    def upright(body: Body) -> tuple[Engine, np.ndarray, Scenario, Body]:
        controller = dataclasses.replace(sector, limbs=body.limbs)
        phases = rng.uniform(0.0, 2 * np.pi, (body.limbs, LANES))
        scenario = Scenario(omega=8.0, phase_rad=phases)
        return Engine(controller=controller, timing=timing), np.ones((LANES, 1)), scenario, body

    art = build("ART")
    walker = Walker()
    walks = dataclasses.replace(sector, limbs=walker.limbs, actuation=FOOT)
    steps = Timing(duration_s=20.0, tick_s=WALKER_TICK_S, frame_s=10 * WALKER_TICK_S)
    phases = rng.uniform(0.0, 2 * np.pi, (walker.limbs, LANES))
    stands = Scenario(omega=OMEGA, height_m=walker.touching_height_m, phase_rad=phases)
    gains = np.full((LANES, 1), 1.25)
    weights = 0.5 * rng.normal(size=(LANES, art.n_weights))
    return {
        "ART on a hopper": (
            Engine(controller=art, timing=Timing(duration_s=10.0)),
            weights,
            Scenario(omega=5.0),
            Hopper(),
        ),
        "a sector on a bar": upright(Bar()),
        "a sector on a plate": upright(Plate()),
        "feet of a walker": (Engine(controller=walks, timing=steps), gains, stands, walker),
    }


def core_seconds(function: Callable[[], Any]) -> float:
    """Seconds that cores are at work."""
    begun = time.process_time()
    function()
    return time.process_time() - begun


def row(engine: Engine, weights: np.ndarray, scenario: Scenario, body: Body) -> list[float]:
    """Core-seconds until code runs; ticks per core-second of 1, 2 and 3 vectors."""
    timing = engine.timing
    lanes = LaneInputs(*as_lanes(engine.controller, body, weights, scenario, "float32"))
    numbers = jax.tree.map(lambda x: np.asarray(x, "float32"), body)
    shared = Shared(numbers, np.asarray(timing.tick_s, "float32"))
    program = EpisodeProgram(engine.controller, engine.integrator, NEEDS)
    episode = TracedEpisode(program.start, program.tick, program.frame)
    kernels: dict[int, Kernel] = {}

    def compiled(vectors: int) -> None:
        kernels[vectors] = compile_episode(episode, lanes, shared, "float32", vectors=vectors)

    took = [core_seconds(lambda v=v: compiled(v)) for v in (2, 1, 3)]

    def native(vectors: int) -> None:
        kernels[vectors].run(
            lanes,
            shared,
            frames=timing.n_frames,
            ticks_per_frame=timing.ticks_per_frame,
            threads=1,
            collect=lambda *group: None,
        )

    ways = [lambda v=v: native(v) for v in (1, 2, 3)]
    times = np.array([[core_seconds(way) for way in ways] for _ in range(REPEATS)])
    best = times.min(axis=0)
    ticks = LANES * timing.n_frames * timing.ticks_per_frame
    return [took[0], *(ticks / each for each in best)]


def main() -> None:
    """Print the table."""
    print("| program | until it runs [core-s] | 1 vector | 2 | 3 |")
    print("|---|---|---|---|---|")
    for name, of in programs().items():
        until, *rates = row(*of)
        shown = " | ".join(f"{rate:.2g}" for rate in rates)
        print(f"| {name} | {until:.1f} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
