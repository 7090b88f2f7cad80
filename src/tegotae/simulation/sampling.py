"""One sample of limbs that another simulator moves: the controller's half of a tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import jax

from tegotae.parts._shapes import PerLimb, StateTree
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Signals
from tegotae.simulation.integrators.base import (
    decide,
    held,
    phase_of,
    push,
    settled,
    with_oscillator,
)


def sample(
    controller: Controller,
    weights: jax.Array,
    oscillator: StateTree,
    sensed: dict[str, PerLimb],
    added: PerLimb,
    numbers: Mapping[str, Any],
) -> tuple[StateTree, jax.Array, jax.Array, jax.Array]:
    """One sample of limbs on an environment, held over its step.

    Args:
        controller: of all limbs.
        weights: [n_weights, lanes].
        oscillator: the oscillators' state.
        sensed: what the limbs sense by signal, [(limbs,) lanes] each.
        added: feedback from elsewhere [rad/s].
        numbers: `omega`, `scales`, `max_force` and `step_s`.

    Returns:
        The oscillators a step on; the mean force over the step as a share of α, or places; the
        feedback; the phase a step on.
    """
    rows = controller.spread(tuple(weights[i] for i in range(weights.shape[0])))
    omega, max_force, step_s = (numbers[name] for name in ("omega", "max_force", "step_s"))
    signals = with_oscillator(controller, Signals(sensed, numbers["scales"]), oscillator)
    drive = decide(controller, rows, omega, signals, oscillator, max_force, added=added)
    ahead = held(oscillator, drive.rate, step_s)
    if controller.actuation.commands_force:
        begins, ends = (phase_of(controller, each, drive.feedback) for each in (oscillator, ahead))
        force = push(controller, max_force, drive.command, begins, ends, omega)
        command = force.mean_n / max_force
    else:
        command = drive.command
    ahead = settled(controller, ahead)
    return ahead, command, drive.feedback, phase_of(controller, ahead, drive.feedback)
