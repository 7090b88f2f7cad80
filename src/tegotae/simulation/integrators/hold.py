"""A controller that is held over a control period."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax

from tegotae.parts._shapes import PerLane, PerLimb, Scalar, StateTree, Weights
from tegotae.parts.bodies import Body, Contact, Push
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Signals
from tegotae.simulation.integrators.base import (
    Integrator,
    Moment,
    decide,
    drive,
    held,
    largest_force,
    phase_of,
    push,
    settled,
    to_limbs,
    with_oscillator,
)


@dataclass(frozen=True)
class Hold(Integrator):
    """Feedback and command evaluated at the tick's start and held; the body advances exactly.

    With t_n the tick's start and T its length, for t in [t_n, t_n + T):

        f(t) = f(t_n),   F_a(t) = F_a(t_n),   φ(t_n + T) = φ(t_n) + T φ̇(t_n).

    It is how a microcontroller runs a controller. A foot that is commanded to a place is on its way
    there during the tick (`Push`).

    Reference: K. J. Åström, B. Wittenmark, Computer-Controlled Systems (1997), on zero-order hold.
    """

    def tick(
        self,
        controller: Controller,
        body: Body,
        weights: Weights,
        omega: PerLimb,
        moment: Moment,
        ground_m: PerLane,
        tick_s: Scalar,
    ) -> tuple[Moment, Contact, Push]:
        """One tick; see `Integrator.tick`."""
        now = drive(controller, body, weights, omega, moment.body, moment.oscillator, ground_m)
        oscillator = held(moment.oscillator, now.rate, tick_s)
        phase = phase_of(controller, moment.oscillator, now.feedback)
        force = push(controller, largest_force(body), now.command, phase, phase, omega)
        force = to_limbs(controller, force)
        state, contact = body.advance(moment.body, force, ground_m, tick_s)
        return Moment(state, oscillator, now, moment.drive), contact, force


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
