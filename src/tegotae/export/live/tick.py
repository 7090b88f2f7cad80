"""A controller's tick as machine code."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_N
from tegotae.export.live.file import NativeController
from tegotae.lowering.function import FunctionKernel, compile_function
from tegotae.parts._shapes import Number, PerLimb, StateTree
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import Signals
from tegotae.simulation.integrators.base import (
    decide,
    held,
    largest_force,
    phase_of,
    push,
    settled,
    to_limbs,
    to_units,
    with_oscillator,
)
from tegotae.systems.controller_file import SavedController
from tegotae.systems.system import System


def compiled(saved: SavedController, max_force_n: float | None = None) -> NativeController:
    """A saved controller as code for this kind of processor.

    Args:
        saved: the controller.
        max_force_n: the force at full push [N], where the file does not know it.

    Raises:
        TegotaeError: for a largest force that is missing, known already or out of range.
        CannotLower: for an operation that has no native code.
    """
    tick = live_tick(saved.system, np.asarray(saved.weights), max_force_n)
    controller = saved.controller
    by_phase = type(controller.oscillator) is PhaseOscillator
    of_oscillator = [name for name in tick.start if name.startswith("oscillator")]
    return NativeController(
        name=saved.name,
        senses=tick.senses,
        commands=controller.actuation.COMMANDS,
        limbs=controller.limbs,
        omega_rad_per_s=saved.omega,
        phase_entry=of_oscillator[0] if by_phase else None,
        start=tick.start,
        state=tick.kernel.state,
        inputs=tick.kernel.inputs,
        outputs=tick.kernel.outputs,
        code=tick.kernel.object_file(),
    )


class LiveTick(NamedTuple):
    """A compiled tick, and what its caller must know of it."""

    kernel: FunctionKernel
    """Its state is `start`; it takes `signals`, `omega` and `elapsed_s`, and gives `command`,
    `phase_rad`, `feedback_rad_per_s`, and whether all of them and the next state are `finite`; if
    not, state and outputs stay as they were."""
    start: dict[str, np.ndarray]
    """The state before the first step, every oscillator at the phase of the system's release."""
    senses: tuple[str, ...]
    """The signals that the controller reads, in the order of the body's senses."""


def live_tick(system: System, weights: np.ndarray, max_force_n: float | None = None) -> LiveTick:
    """The tick of a controller with its weights, for one robot.

    The oscillators advance at the rate of the last step for as long as has passed since; then the
    controller is evaluated, and its command holds until the next step. At equal steps that is
    `Hold`, and what an exported C program does.

    Args:
        system: controller, body or interface, ω and release.
        weights: shape [n_weights].
        max_force_n: the force α at full push [N], where the system's interface does not know it.

    Raises:
        TegotaeError: for an interface without a largest force, for another one than the system's,
            or for one out of range.
        CannotLower: for an operation that has no native code.
    """
    controller, body = system.controller, system.body
    limbs = controller.limbs
    scales, rate_scale = _scales(body)
    most = _largest_force(body, max_force_n)
    senses = _senses(controller, body.senses if isinstance(body, Interface) else body.SENSES)
    shape = (*controller.limb_shape, 1)
    rows = controller.spread(tuple(np.asarray(weights, np.float32)[:, None]))

    def tick(
        state: dict[str, StateTree], inputs: dict[str, StateTree]
    ) -> tuple[dict[str, StateTree], dict[str, jax.Array]]:
        omega = jnp.broadcast_to(inputs["omega"], shape)
        oscillator = jax.tree.unflatten(structure, state["oscillator"])
        oscillator = settled(controller, held(oscillator, state["rate"], inputs["elapsed_s"]))
        sensed = {name: to_units(controller, x) for name, x in inputs["signals"].items()}
        signals = with_oscillator(controller, Signals(sensed, scales), oscillator)
        drive = decide(controller, rows, omega, signals, oscillator, most, rate_scale=rate_scale)
        phase = phase_of(controller, oscillator, drive.feedback)
        command = push(controller, most, drive.command, phase, phase, omega)
        outputs = {
            "command": _of_commands(to_limbs(controller, command).mean_n, controller),
            "phase_rad": _in_order_of_limbs(jnp.broadcast_to(phase, shape), controller),
            "feedback_rad_per_s": _in_order_of_limbs(
                jnp.broadcast_to(drive.feedback, shape), controller
            ),
        }
        after = {
            "oscillator": jax.tree.leaves(oscillator),
            "outputs": outputs,
            "rate": jax.tree.leaves(drive.rate),
        }
        finite = jnp.stack([jnp.isfinite(x).all() for x in jax.tree.leaves(after)]).all()
        after = jax.tree.map(lambda new, old: jnp.where(finite, new, old), after, state)
        return after, {**after["outputs"], "finite": finite}

    release = system.release.scenario(system.omega)
    phases = np.broadcast_to(np.asarray(release.phase_rad, np.float32).reshape(-1, 1), (limbs, 1))
    began = _started(controller, jnp.asarray(phases.reshape(shape)), dict(release.oscillator_state))
    leaves, structure = jax.tree.flatten(began)
    of_limbs = np.zeros((limbs, 1), np.float32)
    outputs = {
        "command": np.zeros((len(controller.actuation.COMMANDS), limbs, 1), np.float32),
        "phase_rad": of_limbs,
        "feedback_rad_per_s": of_limbs,
    }
    state = {
        "oscillator": leaves,
        "outputs": outputs,
        "rate": [jnp.zeros_like(x) for x in leaves],
    }
    number, signal = np.float32(0.0), np.zeros(shape, np.float32)
    inputs = {
        "signals": dict.fromkeys(senses, signal),
        "omega": number,
        "elapsed_s": number,
    }
    kernel = compile_function(tick, state, inputs)
    names = [entry.name for entry in kernel.state.entries]
    start = dict(zip(names, map(np.asarray, jax.tree.leaves(state)), strict=True))
    return LiveTick(kernel, start, senses)


def _senses(controller: Controller, sensed: tuple[str, ...]) -> tuple[str, ...]:
    """What the body senses and a term or coupling reads."""
    reads = {name for term in controller.terms.values() for name in term.reads}
    if controller.coupling is not None:
        reads.update(controller.coupling.READS)
    return tuple(name for name in sensed if name in reads)


def _scales(body: Body | Interface) -> tuple[dict[str, Number], Number | None]:
    """What networks divide signals by, and the feedback."""
    if isinstance(body, Interface):
        known = body.known_scales
        return dict(known), known.get("feedback")
    one = jnp.ones((1,), jnp.float32)
    return dict(body.sense(body.release(one, one), one).scales), body.rate_scale


def _largest_force(body: Body | Interface, given: float | None) -> Number:
    known = body.max_force_n if isinstance(body, Interface) else largest_force(body)
    if given is None:
        if known is None:
            raise TegotaeError(
                "the controller's file does not say the largest force; give max_force_n "
                "(--max-force), such as that of the wiring that it was trained with"
            )
        return known
    require_finite("max_force_n", given, above=0.0, most=MOST_N)
    if known is not None:
        raise TegotaeError(
            f"max_force_n is {given:g}, and the controller's file has its largest force already; "
            "leave it out"
        )
    return given


def _started(controller: Controller, phases: PerLimb, state: Mapping[str, Number]) -> StateTree:
    if controller.oscillator is None:
        return ()
    whole = {name: jnp.full_like(phases, x) for name, x in state.items()}
    return controller.oscillator.start(phases, **whole)


def _of_commands(command: jax.Array, controller: Controller) -> jax.Array:
    """[commands, limbs, 1], whether there is one command or several, one limb or several."""
    return jnp.reshape(command, (len(controller.actuation.COMMANDS), controller.limbs, 1))


def _in_order_of_limbs(of_units: PerLimb, controller: Controller) -> jax.Array:
    """What units give in the order of the limbs, [limbs, 1]."""
    x = jnp.reshape(of_units, (controller.limbs, 1))
    if controller.wiring is None:
        return x
    return jnp.stack([x[controller.wiring.index(limb)] for limb in range(controller.limbs)])
