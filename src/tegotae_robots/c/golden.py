"""Golden vectors: ticks of the package's own run, and the program that checks the C with them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Number, PerLimb, StateTree
from tegotae.parts.bodies import Body
from tegotae.simulation.integrators import Hold, held, settled
from tegotae.simulation.loop import ClosedLoop, Lane
from tegotae.simulation.world import Scenario, ground_m
from tegotae_robots.c.legs import leg_rows
from tegotae_robots.c.plan import Export, facts, member
from tegotae_robots.c.text import filled_c, floating, wrapped

TOLERANCE = 1e-5
"""Largest error allowed, relative to the golden number or to its column's size."""
_DURATION_S = 4.0
"""Simulated time of the run."""
_VECTORS = 1000
"""Number of its ticks that are written."""
_RATE_HZ = 1.7
"""Rate at which a drawn sense repeats [Hz]."""


@dataclass(frozen=True)
class Golden:
    """Ticks of a run: from the state and the inputs at their start to outputs and next state.

    Args:
        columns: what each number of a tick is.
        rows: [ticks, columns], float32.
        times_s: when each tick began [s].
    """

    columns: tuple[str, ...]
    rows: np.ndarray
    times_s: np.ndarray

    def csv(self) -> str:
        """Return the ticks as a table."""
        stream = io.StringIO()
        stream.write(",".join(("t_s", *self.columns)) + "\n")
        for time, row in zip(self.times_s, self.rows, strict=True):
            stream.write(",".join([f"{time:g}", *(str(x) for x in row)]) + "\n")
        return stream.getvalue()


def vector_initialiser(rows: np.ndarray) -> str:
    """Return rows of numbers as an array of C."""
    return ",\n".join(wrapped("{" + ", ".join(map(floating, row)) + "}") for row in rows)


def golden(export: Export) -> Golden:
    """Run a controller on its body in Python, at the export's tick.

    A controller that was trained on an environment has no body here, and drawn senses.

    Raises:
        TegotaeError: if no tick of it has finite numbers.
    """
    ticks = max(1, round(_DURATION_S / export.tick_s))
    run = _run_on_body if isinstance(export.body, Body) else _run_on_drawn_senses
    rows = np.asarray(run(export, ticks))
    finite = np.isfinite(rows).all(axis=1)
    if not finite.any():
        raise TegotaeError("the controller's own simulation gives no finite numbers at this tick")
    valid = np.arange(ticks)[finite]
    valid = valid[:: max(1, len(valid) // _VECTORS)][:_VECTORS]
    return Golden(_columns(export), rows[valid].astype(np.float32), valid * export.tick_s)


def _columns(export: Export) -> tuple[str, ...]:
    """Return the names of the numbers of a tick: state, inputs, outputs, next state."""
    state = [f"state.{name}" for name in export.state_names]
    outputs = [f"out.{name}" for name in export.outputs]
    next_names = [f"next.{name}" for name in export.state_names]
    names = [*state, *(f"in.{member(name)}" for name in export.senses), *outputs, *next_names]
    if export.limbs == 1:
        return tuple(names)
    return tuple(f"{name}[{i}]" for name in names for i in range(export.limbs))


def _ticked(
    export: Export,
    omega: PerLimb,
    state: StateTree,
    sensed: Mapping[str, PerLimb],
    scales: Mapping[str, Number] | None = None,
) -> tuple[StateTree, jax.Array]:
    """Return the next state of the oscillators, and a tick's numbers in the order of the
    columns.
    """
    controller, tick_s = export.controller, jnp.asarray(export.tick_s, jnp.float32)
    decision = export.decide(
        omega, state, sensed, scales, ahead_s=tick_s if export.averages else None
    )
    next_state = settled(controller, held(state, decision.rate, tick_s))
    parts = [*jax.tree.leaves(state), *(sensed[n] for n in export.senses)]
    parts += [*decision.command, decision.feedback, *([decision.phase] if export.has_phase else [])]
    parts += jax.tree.leaves(next_state)
    shape = (export.limbs, 1)
    rows = [jnp.broadcast_to(jnp.reshape(x, (-1, 1)), shape).reshape(-1) for x in parts]
    return next_state, jnp.concatenate(rows)


def _phases(export: Export) -> list[float]:
    """Return the phases of the run, a different one for every oscillator [rad]."""
    return [0.1 + 2.3 * i % 6.0 for i in range(export.limbs)]


def release(export: Export) -> Scenario:
    """Return the release of the run, from slightly above the ground."""
    body, several = export.saved.body, export.limbs > 1
    above = 0.2 * float(np.asarray(body.rest_length_m)) if body.COMMANDS == ("force",) else 0.0
    touching = float(np.asarray(body.touching_height_m))
    numbers = Scenario.at_frequency(export.saved.omega, height_m=touching + above)
    lanes = jax.tree.map(lambda x: jnp.full((1,), x, jnp.float32), numbers)
    phases = jnp.asarray(_phases(export), jnp.float32)
    return lanes._replace(phase_rad=phases[:, None] if several else phases)


def _run_on_body(export: Export, ticks: int) -> jax.Array:
    loop = ClosedLoop(export.controller, Hold())
    tick_s = jnp.asarray(export.tick_s, jnp.float32)
    weights, scenario = loop.spread(list(jnp.asarray(export.weights)[:, None]), release(export))

    @jax.jit
    def run(body: Body) -> jax.Array:
        def tick(lane: Lane, index: jax.Array) -> tuple[Lane, jax.Array]:
            ground = ground_m(scenario, index, tick_s)
            felt = body.sense(lane.moment.body, ground)
            scales = {**felt.scales, "feedback": body.rate_scale}
            row = _ticked(export, scenario.omega, lane.moment.oscillator, felt.values, scales)[1]
            return loop.tick(weights, body, scenario, lane, index, tick_s)[0], row

        return jax.lax.scan(tick, loop.start(weights, body, scenario, tick_s), jnp.arange(ticks))[1]

    return run(export.saved.body)


def _run_on_drawn_senses(export: Export, ticks: int) -> jax.Array:
    controller = export.controller
    shape = (*controller.limb_shape, 1)
    omega = jnp.full(shape, export.saved.omega or 0.0, jnp.float32)
    start = ()
    if controller.oscillator is not None:
        start = controller.oscillator.start(
            jnp.asarray(_phases(export), jnp.float32).reshape(shape)
        )

    def tick(state: StateTree, sensed: dict[str, jax.Array]) -> tuple[StateTree, jax.Array]:
        return _ticked(export, omega, state, sensed)

    senses = {name: jnp.asarray(x) for name, x in drawn(export, ticks).items()}
    return jax.lax.scan(tick, start, senses, length=ticks)[1]


def drawn(export: Export, ticks: int) -> dict[str, np.ndarray]:
    """Return senses that sweep from none to twice their scale, each limb's at another time.

    Returns:
        [ticks, (limbs,) 1] for each sense; a load is never below zero.
    """
    time_s = export.tick_s * np.arange(ticks)
    senses = {}
    for k, name in enumerate(export.senses):
        turns = _RATE_HZ * time_s[:, None] + 0.37 * np.arange(export.limbs) + 0.21 * k
        wave = 2.0 * export.scales.get(name, 1.0) * np.sin(2.0 * np.pi * turns)
        wave = np.maximum(wave, 0.0) if name == "spring_force" else wave
        shape = (ticks, *export.controller.limb_shape, 1)
        senses[name] = wave.reshape(shape).astype(np.float32)
    return senses


def check_program(export: Export, golden: Golden) -> str:
    """Return the text of test_PREFIX.c."""
    sizes = np.maximum(np.abs(golden.rows).max(axis=0), np.float32(1e-6))
    several, names = export.limbs > 1, export.state_names
    pushes, upper = export.controller.actuation.commands_force, export.prefix.upper()
    zero = "{0.0f}" if several and export.senses else "0.0f"
    inputs = [member(name) for name in export.senses] or ["unused"]
    i = "[i]" if several else ""
    compared = [(f"out.{n}{i}", n == "phase_rad") for n in export.outputs]
    compared += [(f"state.oscillator{i}.{n}", n == "phase") for n in names]
    legs = np.zeros((0, 0)) if export.legs is None else leg_rows(export)
    return filled_c(
        "test.c",
        {
            **facts(export),
            "rows_count": len(golden.rows),
            "columns_count": len(golden.columns),
            "columns": ", ".join(golden.columns),
            "rows": vector_initialiser(golden.rows),
            "sizes": wrapped(", ".join(map(floating, sizes))),
            "tolerance": floating(TOLERANCE),
            "turns": any(turns for _, turns in compared),
            "phases": "" if not names else ", PHASES" if several else ", 0.0f",
            "nothing": ", ".join(f".{name} = {zero}" for name in inputs),
            "put": put(export, "state."),
            "compared": [
                {"place": place, "by": "around" if turns else "error"} for place, turns in compared
            ],
            "low": "0.0f" if pushes else "-FLT_MAX",
            "high": f"{upper}_MAX_FORCE_N" if pushes else "FLT_MAX",
            "commands_count": len(export.commands),
            "leg_rows": vector_initialiser(legs),
            "leg_rows_count": len(legs),
        },
    )


def put(export: Export, state: str, inputs: str = "in.") -> list[dict[str, Any]]:
    """Return the C places of a limb's numbers of a golden vector, up to the inputs."""
    i = "[i]" if export.limbs > 1 else ""
    places = [f"{state}oscillator{i}.{name}" for name in export.state_names]
    places += [f"{inputs}{member(name)}{i}" for name in export.senses]
    return [{"place": place} for place in places]
