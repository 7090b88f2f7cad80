"""A controller's tick as machine code."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.export.live.file import NativeController
from tegotae.export.robot import RobotController
from tegotae.lowering.function import compile_function
from tegotae.parts._shapes import StateTree
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.simulation.integrators import held, settled
from tegotae.systems.controller_file import SavedController


def compiled(saved: SavedController, max_force_n: float | None = None) -> NativeController:
    """A saved controller as code for this kind of processor, one tick for one robot.

    The oscillators advance at the rate of the last step for as long as has passed since; then the
    controller is evaluated, and its command holds until the next step. At equal steps that is
    `Hold`, and what an exported C program does.

    The code takes `signals`, `omega` and `elapsed_s`, and gives `command`, `phase_rad`,
    `feedback_rad_per_s`, and whether all of them and the next state are `finite`; if not, state and
    outputs stay as they were.

    Args:
        saved: the controller.
        max_force_n: the force at full push [N], where the file does not know it.

    Raises:
        TegotaeError: for a largest force that is missing, known already or out of range.
        CannotLower: for an operation that has no native code.
    """
    robot = RobotController(saved, max_force_n=max_force_n)
    controller = robot.controller
    shape = (*controller.limb_shape, 1)
    began = _started(robot)
    leaves, structure = jax.tree.flatten(began)

    def tick(
        state: dict[str, StateTree], inputs: dict[str, StateTree]
    ) -> tuple[dict[str, StateTree], dict[str, jax.Array]]:
        omega = jnp.broadcast_to(inputs["omega"], shape)
        oscillator = jax.tree.unflatten(structure, state["oscillator"])
        oscillator = settled(controller, held(oscillator, state["rate"], inputs["elapsed_s"]))
        now = robot.decide(omega, oscillator, inputs["signals"])
        outputs = {
            "command": now.command,
            "phase_rad": now.phase,
            "feedback_rad_per_s": now.feedback,
        }
        after = {
            "oscillator": jax.tree.leaves(oscillator),
            "outputs": outputs,
            "rate": jax.tree.leaves(now.rate),
        }
        finite = jnp.stack([jnp.isfinite(x).all() for x in jax.tree.leaves(after)]).all()
        after = jax.tree.map(lambda new, old: jnp.where(finite, new, old), after, state)
        return after, {**after["outputs"], "finite": finite}

    of_limbs = np.zeros((robot.limbs, 1), np.float32)
    state = {
        "oscillator": leaves,
        "outputs": {
            "command": np.zeros((len(robot.commands), robot.limbs, 1), np.float32),
            "phase_rad": of_limbs,
            "feedback_rad_per_s": of_limbs,
        },
        "rate": [jnp.zeros_like(x) for x in leaves],
    }
    number, signal = np.float32(0.0), np.zeros(shape, np.float32)
    inputs = {
        "signals": dict.fromkeys(robot.senses, signal),
        "omega": number,
        "elapsed_s": number,
    }
    kernel = compile_function(tick, state, inputs)
    names = [name for name, _, _ in kernel.layout[0]]
    numbers = [np.asarray(x).tolist() for x in jax.tree.leaves(state)]
    by_phase = type(controller.oscillator) is PhaseOscillator
    return NativeController(
        name=saved.name,
        senses=robot.senses,
        commands=robot.commands,
        limbs=robot.limbs,
        omega_rad_per_s=saved.omega,
        phase_entry=next(x for x in names if x.startswith("oscillator")) if by_phase else None,
        start=dict(zip(names, numbers, strict=True)),
        code=kernel.to_bytes(),
    )


def _started(robot: RobotController) -> StateTree:
    """The oscillators at the release, at its phases."""
    own, system = robot.controller, robot.saved.system
    if own.oscillator is None:
        return ()
    release = system.release.scenario(system.omega)
    phases = np.broadcast_to(
        np.asarray(release.phase_rad, np.float32).reshape(-1, 1), (robot.limbs, 1)
    )
    start = jnp.asarray(phases.reshape((*own.limb_shape, 1)))
    state = {name: jnp.full_like(start, x) for name, x in dict(release.oscillator_state).items()}
    return own.oscillator.start(start, **state)
