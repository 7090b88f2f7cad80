"""What an integrator is: one control tick of controller and body together."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, PerCommand, PerLane, PerLimb, Scalar, StateTree, Weights
from tegotae.parts.bodies import (
    Body,
    Contact,
    Push,
    for_limbs,
)
from tegotae.parts.controller import Controller
from tegotae.parts.terms.base import Signals


class Drive(NamedTuple):
    """The output of the controller at one instant; arrays [(limbs,) lanes]."""

    feedback: PerLimb
    """Tegotae feedback f [rad/s]."""
    command: PerCommand
    """What the actuation commands: an actuator's force [N] in [0, α], without any phase sector; or
    places of the foot [m], [commands, limbs, lanes] (`Body.COMMANDS`)."""
    rate: StateTree
    """Time derivative of the oscillator's state."""


class Moment(NamedTuple):
    """Where a rollout is: all that one tick hands to the next."""

    body: StateTree
    """State of the body."""
    oscillator: StateTree
    """State of the oscillators; () without."""
    drive: Drive
    """The last output of the controller."""
    earlier: Drive
    """The one a tick before; the same at the release."""


class Integrator(ABC):
    """Advances controller and body by one control tick; a frozen dataclass, elementwise."""

    @abstractmethod
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
        """The moment one tick on, what the body did, and the actuators' push on it.

        Args:
            controller: what decides.
            body: what moves.
            weights: spread over the limbs (`Controller.spread`), n_weights arrays.
            omega: ω [rad/s], spread alike, [(limbs,) lanes].
            moment: where the rollout is.
            ground_m: height of the ground [m], [lanes].
            tick_s: control period [s].

        Returns:
            The next moment, the body's `Contact`, and the `Push` of the units on its limbs.
        """


def signals(
    controller: Controller,
    body: Body,
    body_state: StateTree,
    oscillator: StateTree,
    ground_m: PerLane,
) -> Signals:
    """What the feedback terms may read: the body's senses and the oscillator's signals."""
    sensation = body.sense(body_state, ground_m)
    values = {name: to_units(controller, x) for name, x in sensation.values.items()}
    return with_oscillator(controller, Signals(values, dict(sensation.scales)), oscillator)


def with_oscillator(controller: Controller, sensed: Signals, oscillator: StateTree) -> Signals:
    """The senses, and the signals of the oscillator, if there is one."""
    if controller.oscillator is None:
        return sensed
    return sensed.adding(**controller.oscillator.signals(oscillator))


def decide(
    controller: Controller,
    weights: Weights,
    omega: PerLimb,
    signals: Signals,
    oscillator: StateTree,
    max_force_n: Number,
    *,
    rate_scale: Number | None = None,
    added: PerLimb | None = None,
) -> Drive:
    """Evaluate the controller once.

    Args:
        controller: what decides.
        weights: spread over the limbs.
        omega: ω [rad/s], spread over the limbs.
        signals: all that its terms may read.
        oscillator: the oscillators' state.
        max_force_n: α [N].
        rate_scale: what makes the feedback dimensionless for a learned actuation [rad/s].
        added: feedback from elsewhere, such as an agent [rad/s].
    """
    feedback = controller.feedback(weights, signals)
    if added is not None:
        feedback = feedback + added
    everything = signals.adding(scale=rate_scale, feedback=feedback)
    command = controller.command(weights, everything, max_force_n)
    return Drive(feedback, command, controller.rate(weights, oscillator, omega, feedback, signals))


def drive(
    controller: Controller,
    body: Body,
    weights: Weights,
    omega: PerLimb,
    body_state: StateTree,
    oscillator: StateTree,
    ground_m: PerLane,
) -> Drive:
    """The output of the controller on a body in this state."""
    return decide(
        controller,
        weights,
        omega,
        signals(controller, body, body_state, oscillator, ground_m),
        oscillator,
        largest_force(body),
        rate_scale=body.rate_scale,
    )


def largest_force(body: Body) -> Number:
    """α [N], with an axis of the limbs if there are several and it differs from lane to lane."""
    return body.max_force_n if body.limbs == 1 else for_limbs(body.max_force_n)


def moved(state: StateTree, step: Callable[..., jax.Array], *rates: StateTree) -> StateTree:
    """The state after a step, `x + step(rates)`, leaf by leaf."""
    leaves, structure = jax.tree.flatten(state)
    columns = [jax.tree.leaves(rate) for rate in rates]
    ahead = [x + step(*of_leaf) for x, *of_leaf in zip(leaves, *columns, strict=True)]
    return jax.tree.unflatten(structure, ahead)


def held(state: StateTree, rate: StateTree, tick_s: Number) -> StateTree:
    """An oscillator's state after a tick at a held rate."""

    def step(x: jax.Array) -> jax.Array:
        return tick_s * x

    return moved(state, step, rate)


def settled(controller: Controller, oscillator: StateTree) -> StateTree:
    """An oscillator's state as it is kept between ticks."""
    return oscillator if controller.oscillator is None else controller.oscillator.settle(oscillator)


def phase_of(controller: Controller, oscillator: StateTree, like: PerLimb) -> PerLimb:
    """The oscillators' phase [rad]; zero without one."""
    if controller.oscillator is None or not controller.oscillator.has_phase:
        return jnp.zeros_like(like)
    return controller.oscillator.phase(oscillator)


def push(
    controller: Controller,
    max_force_n: Number,
    command: PerCommand,
    phase_start: PerLimb,
    phase_end: PerLimb,
    omega: PerLimb,
) -> Push:
    """The command along a phase path: full force inside the sector, if any, else unchanged.

    Its rise gives the switched part its first moment in time, so that a sector that begins or ends
    inside a tick also displaces the body as it should.
    """
    sector = controller.actuation.full_force(phase_start, phase_end, omega)
    if sector is None:
        return Push(command)
    share, centre = sector
    switched = share * (max_force_n - command)
    return Push(command + switched, 12.0 * switched * (centre - 0.5))


def to_units(controller: Controller, of_limbs: PerLimb) -> PerLimb:
    """What belongs to the body's limbs in the order of the units that feel them."""
    if controller.wiring is None:
        return of_limbs
    return jnp.stack([of_limbs[limb] for limb in controller.wiring])


def to_limbs(controller: Controller, of_units: Push) -> Push:
    """The units' pushes in the order of the body's limbs."""
    if controller.wiring is None:
        return of_units
    order = [controller.wiring.index(limb) for limb in range(controller.limbs)]
    rise = jnp.broadcast_to(jnp.asarray(of_units.rise_n), of_units.mean_n.shape)
    # A command of several numbers has their axis before that of the limbs.
    return Push(*(x[..., jnp.asarray(order), :] for x in (of_units.mean_n, rise)))
