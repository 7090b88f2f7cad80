"""Golden vectors, and the program that checks the exported C against them."""

from __future__ import annotations

import io
import textwrap
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import DTypeLike

from tegotae._support.errors import TegotaeError
from tegotae.export.c.lower import number, wrapped
from tegotae.export.c.plan import Export, member
from tegotae.parts._shapes import StateTree, Weights
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import Hold
from tegotae.simulation.integrators.base import (
    drive,
    held,
    phase_of,
    push,
    settled,
    to_limbs,
)
from tegotae.simulation.integrators.hold import sample
from tegotae.simulation.loop import ClosedLoop, Lane
from tegotae.simulation.world import Scenario, ground_m

_RATE_HZ = 1.7
"""How often a drawn sense comes back."""


def drawn(export: Export, ticks: int) -> dict[str, np.ndarray]:
    """Senses that sweep from none to twice their scale, each limb's at a time of its own.

    Returns:
        [ticks, (limbs,) 1] for each sense; a load is never below zero.
    """
    time_s = export.tick_s * np.arange(ticks)
    found = {}
    for k, name in enumerate(export.senses):
        turns = _RATE_HZ * time_s[:, None] + 0.37 * np.arange(export.limbs) + 0.21 * k
        wave = 2.0 * export.scales.get(name, 1.0) * np.sin(2.0 * np.pi * turns)
        wave = np.maximum(wave, 0.0) if name == "spring_force" else wave
        shape = (ticks, *export.saved.controller.limb_shape, 1)
        found[name] = wave.reshape(shape).astype(np.float32)
    return found


def driven(export: Export, ticks: int) -> jax.Array:
    """Ticks of the limbs as a simulator's environment has them (`integrators.hold`).

    Returns:
        [ticks, columns]: state, senses, commands, feedback, phase and next state.
    """
    controller = export.saved.controller
    assert controller.oscillator is not None  # limbs on an environment have one
    shape = (*controller.limb_shape, 1)
    phases = jnp.asarray(0.1 + 2.3 * np.arange(export.limbs) % 6.0, jnp.float32).reshape(shape)
    most = 1.0 if export.max_force_n is None else export.max_force_n
    numbers = {
        "omega": jnp.float32(export.saved.omega or 0.0),
        "scales": {name: jnp.float32(scale) for name, scale in export.scales.items()},
        "max_force": jnp.float32(most),
        "step_s": jnp.float32(export.tick_s),
    }
    weights = jnp.asarray(export.weights)[:, None]
    force = export.commands == ("force",)

    def tick(state: StateTree, sensed: dict[str, jax.Array]) -> tuple[StateTree, jax.Array]:
        after, command, feedback, _ = sample(
            controller, weights, state, sensed, jnp.zeros(shape, jnp.float32), numbers
        )
        commands = [command * most] if force else list(command)
        oscillator = controller.oscillator
        assert oscillator is not None
        phase = [oscillator.phase(state)] if export.has_phase else []
        parts = [*jax.tree.leaves(state), *(sensed[n] for n in export.senses), *commands]
        parts += [feedback, *phase, *jax.tree.leaves(after)]
        return after, jnp.concatenate([jnp.broadcast_to(x, shape).reshape(-1) for x in parts])

    senses = {name: jnp.asarray(x) for name, x in drawn(export, ticks).items()}
    start = controller.oscillator.start(phases)
    return jax.lax.scan(tick, start, senses, length=ticks)[1]


DURATION_S = 4.0
"""Simulated time of the run."""
VECTORS = 1000
"""How many of its ticks are kept."""


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
        """The ticks as a table."""
        stream = io.StringIO()
        stream.write(",".join(("t_s", *self.columns)) + "\n")
        for time, row in zip(self.times_s, self.rows, strict=True):
            stream.write(",".join([f"{time:g}", *(str(x) for x in row)]) + "\n")
        return stream.getvalue()


def golden(export: Export) -> Golden:
    """The package's own run of a controller on its body, held over the tick of the export.

    A controller that was trained on an environment has no body here, and drawn senses.

    Raises:
        TegotaeError: if no tick of it has finite numbers.
    """
    ticks = max(1, round(DURATION_S / export.tick_s))
    run = driven if isinstance(export.body, Interface) else _run
    rows = np.asarray(run(export, ticks))
    numbers = np.arange(ticks)
    finite = np.isfinite(rows).all(axis=1)
    if not finite.any():
        raise TegotaeError("the controller's own simulation gives no finite numbers at this tick")
    kept = numbers[finite]
    kept = kept[:: max(1, len(kept) // VECTORS)][:VECTORS]
    return Golden(columns(export), rows[kept].astype(np.float32), kept * export.tick_s)


def columns(export: Export) -> tuple[str, ...]:
    """What the numbers of a tick are: state, inputs, outputs, next state."""

    def each(name: str) -> list[str]:
        return [name] if export.limbs == 1 else [f"{name}[{i}]" for i in range(export.limbs)]

    state = [x for name in export.tracer.state_names for x in each(f"state.{name}")]
    inputs = [x for name in export.senses for x in each(f"in.{member(name)}")]
    outputs = [f"out.{name}" for name in outputs_of(export)]
    said = [x for name in outputs for x in each(name)]
    after = [name.replace("state.", "next.") for name in state]
    return (*state, *inputs, *said, *after)


def outputs_of(export: Export) -> list[str]:
    """The numbers among the outputs."""
    phase = ["phase_rad"] if export.has_phase else []
    return [*map(member, export.commands), "feedback_rad_per_s", *phase]


def release(export: Export, dtype: DTypeLike = jnp.float32) -> Scenario:
    """The release of the run: from somewhat above the ground, every oscillator elsewhere."""
    body, limbs = export.saved.body, export.limbs
    touching = float(np.asarray(body.touching_height_m))
    above = 0.2 * float(np.asarray(body.rest_length_m)) if export.commands == ("force",) else 0.0
    phases = jnp.asarray([0.1 + 2.3 * i % 6.0 for i in range(limbs)], dtype)
    numbers = Scenario.of(export.saved.omega, height_m=touching + above)
    lanes = jax.tree.map(lambda x: jnp.full((1,), x, dtype), numbers)
    return lanes._replace(phase_rad=phases[:, None] if limbs > 1 else phases)


def _run(export: Export, ticks: int) -> jax.Array:
    controller, body = export.saved.controller, export.saved.body
    loop = ClosedLoop(controller, Hold())
    tick_s = jnp.asarray(export.tick_s, jnp.float32)
    weights, scenario = loop.spread(list(jnp.asarray(export.weights)[:, None]), release(export))

    @jax.jit
    def run(body: Body) -> jax.Array:
        def tick(lane: Lane, index: jax.Array) -> tuple[Lane, jax.Array]:
            ground = ground_m(scenario, index, tick_s)
            row = _row(export, controller, body, weights, scenario.omega, lane, ground, tick_s)
            return loop.tick(weights, body, scenario, lane, index, tick_s)[0], row

        start = loop.start(weights, body, scenario, tick_s)
        return jax.lax.scan(tick, start, jnp.arange(ticks))[1]

    return run(body)


def _row(
    export: Export,
    controller: Controller,
    body: Body,
    weights: Weights,
    omega: jax.Array,
    lane: Lane,
    ground: jax.Array,
    tick_s: jax.Array,
) -> jax.Array:
    """One tick, as numbers in the order of `columns`."""
    at, state = lane.moment.body, lane.moment.oscillator
    now = drive(controller, body, weights, omega, at, state, ground)
    after = settled(controller, held(state, now.rate, tick_s))
    phase = phase_of(controller, state, now.feedback)
    pushed = push(controller, body.max_force_n, now.command, phase, phase, omega)
    sensed = body.sense(at, ground).values
    said = to_limbs(controller, pushed).mean_n
    commands = [said] if len(export.commands) == 1 else list(said)
    order = range(export.limbs)
    if controller.wiring is not None:
        order = [controller.wiring.index(limb) for limb in order]

    def of_limbs(x: jax.Array) -> jax.Array:
        return x if export.limbs == 1 else x[jnp.asarray(list(order))]

    outputs = [*commands, of_limbs(now.feedback)]
    if export.has_phase:
        outputs.append(of_limbs(phase))
    parts = [*jax.tree.leaves(state), *(sensed[n] for n in export.senses), *outputs]
    parts += jax.tree.leaves(after)
    return jnp.concatenate([jnp.broadcast_to(x, lane.force_n.shape).reshape(-1) for x in parts])


TOLERANCE = 1e-5
"""Largest error allowed, relative to the golden number or to its column's size."""


def check_program(export: Export, golden: Golden) -> str:
    """The text of test_PREFIX.c."""
    prefix, upper = export.prefix, export.prefix.upper()
    rows = ",\n".join(
        wrapped("{" + ", ".join(number(x, "float")[0] for x in row) + "}") for row in golden.rows
    )
    sizes = np.maximum(np.abs(golden.rows).max(axis=0), np.float32(1e-6))
    scale = wrapped(", ".join(number(x, "float")[0] for x in sizes))
    limbs = f"{upper}_LIMBS"
    at = "" if export.limbs == 1 else "[i]"
    columns = len(golden.columns)
    names = export.tracer.state_names

    def loop(lines: list[str]) -> str:
        """A loop over limbs, in which k goes on by one each."""
        return "".join(
            f"    for (int i = 0; i < {limbs}; ++i) {{\n        {line}\n    }}\n" for line in lines
        )

    put = loop([f"state.oscillator{at}.{n} = row[k++];" for n in names])
    put += loop([f"in.{member(n)}{at} = row[k++];" for n in export.senses])

    def compared(text: str, turns: bool) -> str:
        return f"worst = worse(worst, {'around' if turns else 'error'}({text}, row, k)); ++k;"

    got = loop([compared(f"out.{n}{at}", n == "phase_rad") for n in outputs_of(export)])
    got += loop([compared(f"state.oscillator{at}.{n}", n == "phase") for n in names])
    first = f"static const float PHASES[{limbs}] = {{0.0f}};\n\n" if names and at else ""
    phases = "" if not names else ", PHASES" if at else ", 0.0f"
    force = export.commands == ("force",)
    low, high = ("0.0f", f"{upper}_MAX_FORCE_N") if force else ("-FLT_MAX", "FLT_MAX")
    bounded = loop(
        [f"held = held && (out.{member(n)}{at} >= {low}) && (out.{member(n)}{at} <= {high});"
         for n in export.commands]
    )  # fmt: skip
    bounded = textwrap.indent(bounded, " " * 8)
    zero = "{0.0f}" if at else "0.0f"
    senses = [member(n) for n in export.senses] or ["unused"]
    nothing = ", ".join(f".{name} = {zero if export.senses else '0.0f'}" for name in senses)
    bad = "".join(
        f"            for (int i = 0; i < {limbs}; ++i) {{\n                in.{member(n)}{at} = "
        "BAD[(i + n) % BADS];\n            }\n"
        for n in export.senses
    )
    wraps = "phase_rad" in outputs_of(export) or "phase" in names
    around = _AROUND if wraps else ""
    return f"""\
/* test_{prefix}.c: {len(golden.rows)} ticks of a run of the simulator, one by one through
   the C, and inputs that are no numbers. Exit status 0 if all is as it should be. */
#include "{prefix}.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#define ROWS {len(golden.rows)}
#define COLUMNS {columns}
#define TOLERANCE {number(TOLERANCE, "float")[0]}
#define BADS 6

{first}/* {", ".join(golden.columns)}. */
static const float GOLDEN[ROWS][COLUMNS] = {{
{rows}
}};

/* The largest size of each column. */
static const float SIZE[COLUMNS] = {{
{scale}
}};

static const float BAD[BADS] = {{NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.0e30f}};

static float worse(float a, float b)
{{
    return (b <= a) ? a : b;
}}

/* The error of a number, relative to the golden one or to its column. */
static float error(float found, const float *row, int k)
{{
    const float golden = fabsf(row[k]);
    return fabsf(found - row[k]) / ((golden > SIZE[k]) ? golden : SIZE[k]);
}}

{around}static float vector(const float *row)
{{
    {prefix}_state state;
    {prefix}_inputs in = {{{nothing}}};
    {prefix}_outputs out;
    float worst = 0.0f;
    int k = 0;
    {prefix}_init(&state{phases});
{put}    {prefix}_step(&state, &in, &out);
{got}    return out.fault ? INFINITY : worst;
}}

static bool bounded(void)
{{
    {prefix}_state state;
    {prefix}_inputs in = {{{nothing}}};
    {prefix}_outputs out;
    bool held = true;
    {prefix}_init(&state{phases});
    for (int turn = 0; turn < 100; ++turn) {{
        for (int n = 0; n < BADS; ++n) {{
{bad}            {prefix}_step(&state, &in, &out);
{bounded}        }}
    }}
    return held;
}}

int main(void)
{{
    float worst = 0.0f;
    for (int i = 0; i < ROWS; ++i) {{
        worst = worse(worst, vector(GOLDEN[i]));
    }}
    printf("%d golden vectors, largest error %.2g (allowed %.2g)\\n", ROWS, (double)worst,
        (double)TOLERANCE);
    const bool held = bounded();
    printf("outputs of inputs that are no numbers: %s\\n", held ? "bounded" : "OUT OF RANGE");
    return ((worst <= TOLERANCE) && held) ? 0 : 1;
}}
"""


_AROUND = """\
/* The same of an angle, of which whole turns do not count. */
static float around(float found, const float *row, int k)
{
    const float turn = 6.2831855f;
    float gap = fabsf(found - row[k]);
    gap = (turn - gap < gap) ? fabsf(turn - gap) : gap;
    return gap / turn;
}

"""
