"""What an integrator is: one control tick of controller and body together."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from tegotae.bodies import Body, Contact, Push
from tegotae.controller import Controller, Weights
from tegotae.terms.base import Signals


class Drive(NamedTuple):
    """What the controller says at one instant."""

    feedback: jax.Array
    """Tegotae feedback f [rad/s]."""
    smooth_force: jax.Array
    """Actuator force without any phase sector [N], in [0, α]."""
    rate: tuple[jax.Array, ...]
    """Time derivative of the oscillator's state."""


class Moment(NamedTuple):
    """Where a rollout is: all that one tick hands to the next."""

    body: Any
    oscillator: tuple[jax.Array, ...]
    drive: Drive
    earlier: Drive


class Integrator(ABC):
    """Advances controller and body by one control tick; a frozen dataclass, elementwise."""

    @abstractmethod
    def tick(
        self,
        controller: Controller,
        body: Body,
        weights: Weights,
        omega: jax.Array,
        moment: Moment,
        ground_m: jax.Array,
        tick_s: jax.Array,
    ) -> tuple[Moment, Contact, Push]:
        """The moment one tick on, what the body did, and the actuator's push on it."""


def signals(
    controller: Controller, body: Body, body_state: Any, oscillator: tuple, ground_m: jax.Array
) -> Signals:
    """What the feedback terms may read: the body's senses and the phase."""
    sensation = body.sense(body_state, ground_m)
    sensed = Signals(dict(sensation.values), dict(sensation.scales))
    if controller.oscillator is None:
        return sensed
    sine, cosine = controller.oscillator.sin_cos(oscillator)
    return sensed.adding(sin_phase=sine, cos_phase=cosine)


def drive(
    controller: Controller,
    body: Body,
    weights: Weights,
    omega: jax.Array,
    body_state: Any,
    oscillator: tuple,
    ground_m: jax.Array,
) -> Drive:
    """Evaluate the controller once."""
    sensed = signals(controller, body, body_state, oscillator, ground_m)
    feedback = controller.feedback(weights, sensed)
    # The rate √(g/l0) makes the feedback dimensionless for a learned actuation.
    everything = sensed.adding(scale=body.rate_scale, feedback=feedback)
    force = controller.smooth_force(weights, everything, body.max_force_n)
    rate = (
        ()
        if controller.oscillator is None
        else controller.oscillator.rate(oscillator, omega, feedback)
    )
    return Drive(feedback, force, rate)


def phase_of(controller: Controller, oscillator: tuple, like: jax.Array) -> jax.Array:
    """The oscillator's phase [rad]; zero without an oscillator."""
    if controller.oscillator is None:
        return jnp.zeros_like(like)
    return controller.oscillator.phase(oscillator)


def push(
    controller: Controller,
    body: Body,
    smooth_force: jax.Array,
    phase_start: jax.Array,
    phase_end: jax.Array,
    omega: jax.Array,
) -> Push:
    """The force along a phase path: full force inside the sector, if any, else the smooth force.

    Its rise gives the switched part its first moment in time, so that a sector that begins or ends
    inside a tick also displaces the body as it should.
    """
    sector = controller.actuation.full_force(phase_start, phase_end, omega)
    if sector is None:
        return Push(smooth_force)
    share, centre = sector
    switched = share * (body.max_force_n - smooth_force)
    return Push(smooth_force + switched, 12.0 * switched * (centre - 0.5))
