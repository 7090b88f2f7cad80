"""Integrators: how controller and body advance by one control tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, PerCommand, PerLane, PerLimb, Scalar, StateTree, Weights
from tegotae.parts.bodies import Body, Contact, Push, for_limbs
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Actuation, Signals

__all__ = ["Drive", "Hold", "Integrator", "Moment", "PredictorCorrector", "TickSetting", "sample"]


class Drive(NamedTuple):
    """The output of the controller at one instant; arrays [(limbs,) lanes]."""

    feedback: PerLimb
    """Tegotae feedback f [rad/s]."""
    command: PerCommand
    """Command of the actuation: an actuator's force [N] in [0, α], without any phase sector; or
    positions of the foot [m], [commands, limbs, lanes] (`Body.COMMANDS`)."""
    rate: StateTree
    """Time derivative of the oscillator's state."""


class Moment(NamedTuple):
    """State of a rollout: all that one tick hands to the next."""

    body: StateTree
    """State of the body."""
    oscillator: StateTree
    """State of the oscillators; () without."""
    drive: Drive
    """The last output of the controller."""
    earlier: Drive
    """The one a tick before; the same at the release."""


class TickSetting(NamedTuple):
    """Constants of a control tick: controller, body and conditions."""

    controller: Controller
    """The controller."""
    body: Body
    """The body that it drives."""
    weights: Weights
    """Spread over the limbs (`Controller.spread`), n_weights arrays."""
    omega: PerLimb
    """ω [rad/s], spread alike, [(limbs,) lanes]."""
    ground_m: PerLane
    """Height of the ground [m], [lanes]."""
    tick_s: Scalar
    """Control period [s]."""

    def drive(self, body_state: StateTree, oscillator: StateTree) -> Drive:
        """Return the output of the controller on a body in this state."""
        controller, body, weights, omega, ground_m, _ = self
        sensed = signals(controller, body, body_state, oscillator, ground_m)
        limit, rate_scale = largest_force(body), body.rate_scale
        return decide(controller, weights, omega, sensed, oscillator, limit, rate_scale=rate_scale)

    def push(self, command: PerCommand, phase_start: PerLimb, phase_end: PerLimb) -> Push:
        """Return the units' pushes along a phase path, in the order of the body's limbs."""
        controller, limit = self.controller, largest_force(self.body)
        actuation = controller.actuation, controller.of_part("actuation", self.weights)
        of_units = push(*actuation, limit, command, phase_start, phase_end, self.omega)
        return to_limbs(controller, of_units)


class Integrator(ABC):
    """Advances controller and body by one control tick; a frozen dataclass, elementwise."""

    @abstractmethod
    def tick(self, setting: TickSetting, moment: Moment) -> tuple[Moment, Contact, Push]:
        """Advance one tick: return the moment after it, the body's contact, and the actuators' push
        on it.

        Args:
            setting: what holds during the tick.
            moment: where the rollout is.

        Returns:
            The next moment, the body's `Contact`, and the `Push` of the units on its limbs.
        """


@dataclass(frozen=True)
class Hold(Integrator):
    """Feedback and command evaluated at the tick's start and held; the body advances exactly.

    With t_n the tick's start and T its length, for t in [t_n, t_n + T):

        f(t) = f(t_n),   F_a(t) = F_a(t_n),   φ(t_n + T) = φ(t_n) + T φ̇(t_n).

    It is how a microcontroller runs a controller. A foot that is commanded to a place is on its way
    there during the tick (`Push`).

    Reference: K. J. Åström, B. Wittenmark, Computer-Controlled Systems (1997), on zero-order hold.
    """

    def tick(self, setting: TickSetting, moment: Moment) -> tuple[Moment, Contact, Push]:
        """Advance one tick; see `Integrator.tick`."""
        controller, body, *_, ground_m, tick_s = setting
        drive = setting.drive(moment.body, moment.oscillator)
        oscillator = held(moment.oscillator, drive.rate, tick_s)
        phase = phase_of(controller, moment.oscillator, drive.feedback)
        force = setting.push(drive.command, phase, phase)
        state, contact = body.advance(moment.body, force, ground_m, tick_s)
        return Moment(state, oscillator, drive, moment.drive), contact, force


@dataclass(frozen=True)
class PredictorCorrector(Integrator):
    """Adams predictor-corrector around the exact motion of the body, in PEC form.

    The oscillator is predicted with Adams-Bashforth 2 and the body with its present acceleration;
    the controller is evaluated there, once; feedback and force over the tick follow from
    Adams-Moulton 3, and the body advances exactly under that force, with its contact events and the
    edges of a sector inside the tick. The evaluation at the predicted point serves the next ticks,
    so a tick costs one evaluation and not the two of Heun's method. At 1 ms it has half of that
    method's typical error and a quarter of its largest (convergence study, documentation).

        predicted   φ* = φ + T (3/2 φ̇_n - 1/2 φ̇_{n-1}),
        corrected   φ_{n+1} = φ + T (5/12 φ̇* + 8/12 φ̇_n - 1/12 φ̇_{n-1}).

    Reference: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I,
    section III.1.
    """

    def tick(self, setting: TickSetting, moment: Moment) -> tuple[Moment, Contact, Push]:
        """Advance one tick; see `Integrator.tick`."""
        controller, body, *_, ground_m, tick_s = setting
        current, earlier = moment.drive, moment.earlier
        forces = controller.actuation.commands_force
        phase = phase_of(controller, moment.oscillator, current.feedback)

        def adams_bashforth(rate: jax.Array, rate_earlier: jax.Array) -> jax.Array:
            return tick_s * (1.5 * rate - 0.5 * rate_earlier)

        guess = moved(moment.oscillator, adams_bashforth, current.rate, earlier.rate)
        phase_guess = phase_of(controller, guess, current.feedback)
        # Over a tick a force on average, or at its end a place of the foot.
        command = current.command if forces else 2.0 * current.command - earlier.command
        force = setting.push(command, phase, phase_guess)
        body_guess, *stance = body.predict(moment.body, force.mean_n, ground_m, tick_s)
        stance_from, stance_to = (to_units(controller, share) for share in stance)
        predicted = setting.drive(body_guess, guess)

        oscillator = moved(
            moment.oscillator,
            lambda *rates: tick_s * _adams_moulton(*rates),
            earlier.rate,
            current.rate,
            predicted.rate,
        )
        travel = phase_of(controller, oscillator, current.feedback) - phase
        command = predicted.command
        if forces:
            mean = _adams_moulton(earlier.command, current.command, predicted.command)
            command = jnp.clip(mean, 0.0, largest_force(body))
        force = setting.push(command, phase + stance_from * travel, phase + stance_to * travel)
        state, contact = body.advance(moment.body, force, ground_m, tick_s)
        return Moment(state, oscillator, predicted, current), contact, force


def _adams_moulton(earlier: jax.Array, current: jax.Array, predicted: jax.Array) -> jax.Array:
    """Return the mean over the tick from now to then of the parabola through three evaluations."""
    return (5.0 * predicted + 8.0 * current - earlier) * (1.0 / 12.0)


def signals(
    controller: Controller,
    body: Body,
    body_state: StateTree,
    oscillator: StateTree,
    ground_m: PerLane,
) -> Signals:
    """Collect the signals that feedback terms may read: the body's senses and the oscillator's
    signals."""
    sensation = body.sense(body_state, ground_m)
    values = {name: to_units(controller, x) for name, x in sensation.values.items()}
    return with_oscillator(controller, Signals(values, dict(sensation.scales)), oscillator)


def with_oscillator(controller: Controller, sensed: Signals, oscillator: StateTree) -> Signals:
    """Return the senses, and the signals of the oscillator, if there is one."""
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
    all_signals = signals.adding(scale=rate_scale, feedback=feedback)
    command = controller.command(weights, all_signals, max_force_n)
    return Drive(feedback, command, controller.rate(weights, oscillator, omega, feedback, signals))


class Response(NamedTuple):
    """Response of a controller to the senses of its units, over a time ahead."""

    drive: Drive
    """Output of the controller."""
    phase_rad: PerLimb
    """Phases at the beginning [rad]."""
    ahead: StateTree
    """State of the oscillators at the end, not settled yet."""
    push: Push
    """Pushes of the units."""


def respond(
    controller: Controller,
    weights: Weights,
    omega: PerLimb,
    sensed: Signals,
    oscillator: StateTree,
    max_force_n: Number,
    *,
    rate_scale: Number | None = None,
    added: PerLimb | None = None,
    ahead_s: Number | None = None,
) -> Response:
    """Evaluate the controller's half of a tick: from the senses of its units to their pushes.

    Args:
        controller: what decides.
        weights: spread over the limbs.
        omega: ω [rad/s], spread over the limbs.
        sensed: what its units sense, without the signals of the oscillator.
        oscillator: the oscillators' state.
        max_force_n: α [N].
        rate_scale: what makes the feedback dimensionless for a learned actuation [rad/s].
        added: feedback from elsewhere, such as an agent [rad/s].
        ahead_s: time over which a push is the mean [s]; by default it is that of now.
    """
    signals = with_oscillator(controller, sensed, oscillator)
    drive = decide(
        *(controller, weights, omega, signals, oscillator, max_force_n),
        rate_scale=rate_scale,
        added=added,
    )
    begins = ends = phase_of(controller, oscillator, drive.feedback)
    ahead = oscillator
    if ahead_s is not None:
        ahead = held(oscillator, drive.rate, ahead_s)
        ends = phase_of(controller, ahead, drive.feedback)
    actuation = controller.actuation, controller.of_part("actuation", weights)
    pushed = push(*actuation, max_force_n, drive.command, begins, ends, omega)
    return Response(drive, begins, ahead, pushed)


def largest_force(body: Body) -> Number:
    """α [N], with an axis of the limbs if there are several and it differs from lane to lane."""
    return body.max_force_n if body.limbs == 1 else for_limbs(body.max_force_n)


def moved(state: StateTree, step: Callable[..., jax.Array], *rates: StateTree) -> StateTree:
    """Return the state after a step, `x + step(rates)`, leaf by leaf."""
    leaves, structure = jax.tree.flatten(state)
    columns = [jax.tree.leaves(rate) for rate in rates]
    ahead = [x + step(*of_leaf) for x, *of_leaf in zip(leaves, *columns, strict=True)]
    return jax.tree.unflatten(structure, ahead)


def held(state: StateTree, rate: StateTree, tick_s: Number) -> StateTree:
    """Return an oscillator's state after a tick at a held rate."""

    def step(x: jax.Array) -> jax.Array:
        return tick_s * x

    return moved(state, step, rate)


def settled(controller: Controller, oscillator: StateTree) -> StateTree:
    """Return an oscillator's state as it is kept between ticks."""
    return oscillator if controller.oscillator is None else controller.oscillator.settle(oscillator)


def phase_of(controller: Controller, oscillator: StateTree, like: PerLimb) -> PerLimb:
    """Return the oscillators' phase [rad]; zero without one."""
    if controller.oscillator is None or not controller.oscillator.has_phase:
        return jnp.zeros_like(like)
    return controller.oscillator.phase(oscillator)


def push(
    actuation: Actuation,
    weights: Weights,
    max_force_n: Number,
    command: PerCommand,
    phase_start: PerLimb,
    phase_end: PerLimb,
    omega: PerLimb,
) -> Push:
    """Return the command along a phase path at ω: full force inside the sector, if any.

    Its rise gives the switched part its first moment in time, so that a sector that begins or ends
    inside a tick also displaces the body as it should.
    """
    command = actuation.paced(weights, command, omega)
    sector = actuation.full_force(weights, phase_start, phase_end, omega)
    if sector is None:
        return Push(command)
    share, centre = sector
    switched = share * (max_force_n - command)
    return Push(command + switched, 12.0 * switched * (centre - 0.5))


def to_units(controller: Controller, of_limbs: PerLimb) -> PerLimb:
    """Reorder values of the body's limbs into the order of the units that sense them."""
    if controller.wiring is None:
        return of_limbs
    return jnp.stack([of_limbs[limb] for limb in controller.wiring])


def to_limbs(controller: Controller, of_units: Push) -> Push:
    """Return the units' pushes in the order of the body's limbs."""
    if controller.wiring is None:
        return of_units
    order = [controller.wiring.index(limb) for limb in range(controller.limbs)]
    rise = jnp.broadcast_to(jnp.asarray(of_units.rise_n), of_units.mean_n.shape)
    # A command of several numbers has their axis before that of the limbs.
    return Push(*(x[..., jnp.asarray(order), :] for x in (of_units.mean_n, rise)))


def sample(
    controller: Controller,
    weights: jax.Array,
    oscillator: StateTree,
    sensed: dict[str, PerLimb],
    added: PerLimb,
    numbers: Mapping[str, Any],
) -> tuple[StateTree, jax.Array, jax.Array, jax.Array]:
    """Take one sample of limbs on an environment, held over its step.

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
    decision = respond(
        *(controller, rows, omega, Signals(sensed, numbers["scales"]), oscillator, max_force),
        added=added,
        ahead_s=step_s,
    )
    command, feedback = decision.push.mean_n, decision.drive.feedback
    if controller.actuation.commands_force:
        command = command / max_force
    ahead = settled(controller, decision.ahead)
    return ahead, command, feedback, phase_of(controller, ahead, feedback)
