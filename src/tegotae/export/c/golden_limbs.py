"""Golden vectors of limbs on an environment, whose body is not here: senses are drawn."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.export.c.plan import Export
from tegotae.parts._shapes import StateTree
from tegotae.simulation.integrators.hold import sample

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
