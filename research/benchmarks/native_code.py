"""Measure the cost and the speed of native code: the table of docs/native.md.

    python -m research.benchmarks.native_code

Each row is a program of lanes: core-seconds to trace it, to write it and to compile it, and control
ticks per core-second in blocks of one, two and three vectors. `python -m research.benchmarks` times
XLA. The best of several runs that alternate; a machine in use by others varies by some percent.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lanewise.episode import Kernel, TracedEpisode, compile_episode
from research.benchmarks.legs import FOOT, OMEGA, WALKER_TICK_S
from tegotae import Scenario, Timing
from tegotae.parts.bodies import Bar, Body, Hopper, Plate, Walker
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.simulation.loop import ClosedLoop
from tegotae.simulation.recorder import Recorder
from tegotae.systems.recipe import recipe

LANES = 1056
REPEATS = 5
NEEDS = ("climb_flight_m", "work_positive_j", "work_net_j")
"""Channels that every fitness needs, besides the failure of a lane."""
Program = tuple[Controller, Body, Timing, np.ndarray, Scenario]


def programs() -> dict[str, Program]:
    """Return the timed programs, by name: controller, body, timing, weights [n_weights, lanes],
    scenario."""
    rng = np.random.default_rng(0)
    art, sector, walker = recipe("ART").controller(), recipe("V-sector-w8").controller(), Walker()
    walks = dataclasses.replace(sector, limbs=walker.limbs, actuation=FOOT)
    steps = Timing(duration_s=20.0, tick_s=WALKER_TICK_S, frame_s=10 * WALKER_TICK_S)
    height_m = float(walker.touching_height_m)

    def scenario(limbs: int, omega: float, height_m: float = 1.2) -> Scenario:
        shape = (limbs, LANES) if limbs > 1 else (LANES,)
        phases = rng.uniform(0.0, 2 * np.pi, shape)
        columns = (np.full(LANES, x) for x in (height_m, 0.0, 0.0, np.inf))
        height, velocity, drop, dropped = columns
        return Scenario(np.full(shape, omega), height, velocity, phases, drop, dropped)

    def upright(body: Body) -> Program:
        controller = dataclasses.replace(sector, limbs=body.limbs)
        timing, ones = Timing(duration_s=2.0), np.ones((1, LANES))
        return controller, body, timing, ones, scenario(body.limbs, 8.0)

    weights = 0.5 * rng.normal(size=(art.n_weights, LANES))
    gains = np.full((1, LANES), 1.25)
    return {
        "ART on a hopper": (art, Hopper(), Timing(duration_s=10.0), weights, scenario(1, 5.0)),
        "a sector on a bar": upright(Bar()),
        "a sector on a plate": upright(Plate()),
        "feet of a walker": (walks, walker, steps, gains, scenario(4, OMEGA, height_m)),
    }


def episode(controller: Controller, subject: Body) -> TracedEpisode:
    """Roll out the closed loop with its totals."""
    loop = ClosedLoop(controller, PredictorCorrector())
    recorder = Recorder.for_loop(controller, subject, NEEDS)

    def spread(lanes: Any) -> Any:
        weights, scenario = lanes
        return loop.spread(list(weights), scenario)

    def start(lanes: Any, shared: Any) -> Any:
        (rows, scenario), (body, tick_s) = spread(lanes), shared
        lane = loop.start(rows, body, scenario, tick_s)
        arguments = rows, body, scenario, lane, jnp.int32(0), tick_s
        return lane, recorder.empty(lambda: loop.tick(*arguments)[1])[0]

    def tick(lanes: Any, shared: Any, state: Any, index: Any) -> Any:
        (rows, scenario), (body, tick_s), (lane, totals) = spread(lanes), shared, state
        lane, output = loop.tick(rows, body, scenario, lane, index, tick_s)
        return lane, recorder.add(totals, output)

    def frame(lanes: Any, shared: Any, state: Any, last: Any) -> Any:
        return state, (state[1], state[0].failed)

    return TracedEpisode(start, tick, frame)


def core_seconds(function: Callable[[], Any]) -> float:
    """Return the time for which cores are at work [s]."""
    begun = time.process_time()
    function()
    return time.process_time() - begun


def row(
    controller: Controller, body: Body, timing: Timing, weights: np.ndarray, scenario: Scenario
) -> list[float]:
    """Return core-seconds until code runs, and ticks per core-second of 1, 2 and 3 vectors."""

    def numbers(tree: Any) -> Any:
        return jax.tree.map(lambda x: np.asarray(x, "float32"), tree)

    lanes, shared = numbers((weights, scenario)), numbers((body, timing.tick_s))
    program = episode(controller, body)
    kernels: dict[int, Kernel] = {}

    def compiled(vectors: int) -> None:
        kernels[vectors] = compile_episode(program, lanes, shared, "float32", vectors=vectors)
        _ = kernels[vectors].full.code

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

    variants = [lambda v=v: native(v) for v in (1, 2, 3)]
    times = np.array([[core_seconds(variant) for variant in variants] for _ in range(REPEATS)])
    best = times.min(axis=0)
    ticks = LANES * timing.n_frames * timing.ticks_per_frame
    return [took[0], *(ticks / seconds for seconds in best)]


def main() -> None:
    """Print the table."""
    print("| program | until it runs [core-s] | 1 vector | 2 | 3 |")
    print("|---|---|---|---|---|")
    for name, program in programs().items():
        until, *rates = row(*program)
        text = " | ".join(f"{rate:.2g}" for rate in rates)
        print(f"| {name} | {until:.1f} | {text} |", flush=True)


if __name__ == "__main__":
    main()
