"""Compiled controllers that drive the package's bodies, and the package's own runs beside."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from compiled import Compiled
from tegotae.parts.bodies import Body
from tegotae.parts.bodies.base import Push
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.controller_file import SavedController

TICK_S, DURATION_S = 0.001, 20.0
HELD = Timing(duration_s=DURATION_S, tick_s=TICK_S, frame_s=0.02)


def own_run(saved: SavedController, timing: Timing, **release: Any) -> Any:
    """The package's own run of a controller, held over the ticks."""
    rollout = Rollout(controller=saved.controller, integrator=Hold(), timing=timing)
    return rollout.run(
        np.asarray(saved.weights), Scenario.at_frequency(saved.omega, **release), saved.body
    )


def apexes_of_the_package(saved: SavedController, **release: Any) -> tuple[np.ndarray, np.ndarray]:
    """Times and heights of the apexes of the package's own run, held over the ticks."""
    result = own_run(saved, HELD, **release)
    times, heights = (np.asarray(x)[:, 0] for x in (result.apex_time_s, result.apex_height_m))
    return times[~np.isnan(times)], heights[~np.isnan(heights)]


def as_simulated(program: Compiled, sensed: dict, pushed: float) -> list:
    """The inputs that the simulator gives."""
    return [sensed[name] for name in program.export.senses]


def driven(
    programs: list[Compiled],
    body: Body,
    height_m: float,
    phases: Any,
    measured: Any = as_simulated,
    *,
    timing: Timing = HELD,
    recorded: Any = lambda state, contact: contact.apex_height_m,
) -> np.ndarray:
    """Compiled controllers drive one body each, tick by tick; what each records, ticks first.

    `measured` says what a robot's sensors give, one for all or one a robot.
    """
    measures = measured if isinstance(measured, list) else [measured] * len(programs)
    lanes, limbs = len(programs), body.limbs
    state = body.release(jnp.full(lanes, height_m), jnp.zeros(lanes))
    ground, step_s = jnp.zeros(lanes), jnp.float32(timing.tick_s)
    numbers = len(programs[0].export.commands)
    command = np.zeros((numbers, limbs, lanes), np.float32)

    @jax.jit
    def sense(state: Any) -> dict:
        return body.sense(state, ground).values

    @jax.jit
    def advance(state: Any, command: Any) -> tuple:
        updated, contact = body.advance(state, Push(command), ground, step_s)
        return updated, body.sense(updated, ground).values, recorded(updated, contact)

    def say(sensed: dict) -> Any:
        values = {name: np.asarray(x) for name, x in sensed.items()}
        for lane, program in enumerate(programs):
            readings = {name: x[..., lane] for name, x in values.items()}
            inputs = measures[lane](program, readings, command[0, 0, lane])
            command[..., lane] = program.step(inputs)[:numbers]
        message = command[0] if numbers == 1 else command
        return message[0] if limbs == 1 else message

    def begin() -> None:
        for program in programs:
            program.init(phases)

    # A foot that is commanded to a place is released there.
    begin()
    state = body.commanded(state, jnp.asarray(say(sense(state))))
    begin()
    command[:] = 0.0
    sensed, result = sense(state), []
    for _ in range(round(timing.duration_s / timing.tick_s)):
        state, sensed, entry = advance(state, say(sensed))
        result.append(entry)
    return np.stack([np.asarray(entry) for entry in result])


def apexes_of_the_robots(
    programs: list[Compiled], body: Body, height_m: float, phases: Any, measured: Any = as_simulated
) -> list[np.ndarray]:
    """Heights of the apexes [m] of each."""
    apexes = driven(programs, body, height_m, phases, measured)
    return [column[~np.isnan(column)] for column in apexes.T]


def is_regular(heights: np.ndarray, periods: int = 4) -> bool:
    """Return True if apexes [m] repeat themselves within a millimetre, after so many hops at
    most."""
    return any(
        len(heights) > 2 * k and np.abs(heights[k:] - heights[:-k]).max() < 1e-3
        for k in range(1, periods + 1)
    )
