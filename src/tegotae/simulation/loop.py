"""The closed loop of controller, body and world, and its one control tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Index, MaskPerLane, PerLane, PerLimb, Scalar, Weights
from tegotae.parts.bodies import Body, Contact, Interface
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import Integrator, Moment, TickSetting, phase_of, settled
from tegotae.simulation.world import Scenario, apply_changes, ground_m


class Lane(NamedTuple):
    """State of a lane, carried from one control tick to the next."""

    moment: Moment
    """State of body and oscillators, and the last output of the controller."""
    force_n: PerLimb
    """Mean actuator force over the last tick [N], zero in flight; [(limbs,) lanes]."""
    failed: MaskPerLane
    """True for lanes that have failed; they stand still. [lanes]"""


class Tick(NamedTuple):
    """Results of a control tick, the source of channels and rewards."""

    number: Index
    """Its number, from 0 on."""
    tick_s: Scalar
    """Its duration [s]."""
    sound: MaskPerLane
    """True for lanes that have not failed, [lanes]."""
    body: Body
    """The body as it is during the tick."""
    contact: Contact
    """Motion and events of the body."""
    force_n: PerLimb
    """Mean actuator force, zero in flight [N], [(limbs,) lanes]."""
    phase_rad: PerLimb
    """Phase at its start [rad], [(limbs,) lanes]."""
    travel_rad: PerLimb
    """Motion of the phase [rad], [(limbs,) lanes]."""
    end: Moment
    """State at its end, of a lane that did not fail."""
    ground_m: PerLane
    """Height of the ground [m], [lanes]."""


@dataclass(frozen=True)
class ClosedLoop:
    """Controller and body under an integrator, and the one control tick that there is.

    Rollouts, environments and benchmarks all advance by `tick`. Weights and frequency are spread
    over the limbs once (`spread`), before the first tick.

    Args:
        controller: what drives the body.
        integrator: how both advance by a tick.
    """

    controller: Controller
    integrator: Integrator

    def spread(self, weights: Weights, scenario: Scenario) -> tuple[Weights, Scenario]:
        """Return weights, frequency and phase limb by limb: [(limbs,) lanes]."""
        shape = (*self.controller.limb_shape, *jnp.shape(scenario.height_m))

        def per_limb(x: jax.Array) -> jax.Array:
            return jnp.broadcast_to(x, shape)

        scenario = scenario._replace(
            omega=per_limb(scenario.omega),
            phase_rad=per_limb(scenario.phase_rad),
            oscillator_state={
                name: per_limb(x) for name, x in dict(scenario.oscillator_state).items()
            },
        )
        return self.controller.spread(weights), scenario

    def meets(
        self, body: Body, scenario: Scenario, index: Index, tick_s: Scalar
    ) -> tuple[Body, PerLimb]:
        """Return body and frequency as they are during a tick (`Scenario.changes`)."""
        return apply_changes(body, scenario.omega, dict(scenario.changes), index, tick_s)

    def start(self, weights: Weights, body: Body, scenario: Scenario, tick_s: Scalar) -> Lane:
        """Return the lane at its release."""
        controller = self.controller
        body, omega = self.meets(body, scenario, jnp.asarray(0), tick_s)
        state = body.release(
            scenario.height_m, scenario.velocity_m_per_s, **dict(scenario.initial_pose)
        )
        oscillator = (
            ()
            if controller.oscillator is None
            else controller.oscillator.start(scenario.phase_rad, **dict(scenario.oscillator_state))
        )
        ground = ground_m(scenario, jnp.asarray(0), tick_s)
        setting = TickSetting(controller, body, weights, omega, ground, tick_s)
        state = body.commanded(state, setting.drive(state, oscillator).command)
        control = setting.drive(state, oscillator)
        failed = ~jnp.isfinite(
            scenario.height_m
            + scenario.velocity_m_per_s
            + over_limbs(jnp.sum, scenario.omega, body)
        )
        return Lane(
            Moment(state, oscillator, control, control), jnp.zeros_like(scenario.omega), failed
        )

    def tick(
        self,
        weights: Weights,
        body: Body,
        scenario: Scenario,
        lane: Lane,
        index: Index,
        tick_s: Scalar,
    ) -> tuple[Lane, Tick]:
        """Advance one control tick; return the lane after it, and its output.

        A lane that fails stands still from its last sound tick on; `keep` holds for its totals.

        Args:
            weights: spread over the limbs.
            body: the body.
            scenario: spread over the limbs.
            lane: where the lane is.
            index: the tick's number.
            tick_s: the control period [s].
        """
        controller = self.controller
        ground = ground_m(scenario, index, tick_s)
        body, omega = self.meets(body, scenario, index, tick_s)
        setting = TickSetting(controller, body, weights, omega, ground, tick_s)
        moment, contact, push = self.integrator.tick(setting, lane.moment)
        phase = phase_of(controller, lane.moment.oscillator, lane.force_n)
        travel = phase_of(controller, moment.oscillator, lane.force_n) - phase
        moment = moment._replace(oscillator=settled(controller, moment.oscillator))
        sound = ~lane.failed & ~body.failed(moment.body, ground)
        sound &= jnp.isfinite(body.height(moment.body))
        sound &= over_limbs(jnp.all, jnp.isfinite(travel), body)
        force = push.mean_n * contact.stance_share if contact.force_n is None else contact.force_n
        advanced = Lane(moment, force, lane.failed)
        lane_state = jax.tree.map(partial(keep, sound), advanced, lane)
        output = Tick(index, tick_s, sound, body, contact, force, phase, travel, moment, ground)
        return lane_state._replace(failed=~sound), output


def keep(sound: MaskPerLane, new: jax.Array, old: jax.Array) -> jax.Array:
    """Return the new value in sound lanes, the old one in others; with or without a limb axis.

    Args:
        sound: which lanes go on, [lanes].
        new: [(limbs,) lanes].
        old: like `new`.
    """
    return jnp.where(jnp.broadcast_to(sound, jnp.shape(new)), new, old)


def over_limbs(reduce: Callable[..., jax.Array], x: jax.Array, body: Body) -> jax.Array:
    """Reduce over the limbs of a lane, for example to their sum; return `x` itself for a single
    limb.

    Args:
        reduce: over an axis, such as `jnp.sum` or `jnp.all`.
        x: [(limbs,) lanes].
        body: which has one limb or several.
    """
    return x if body.limbs == 1 else reduce(x, axis=0)


def check_senses(controller: Controller, body: Body | Interface) -> None:
    """Raise `TegotaeError` if controller and body do not go together.

    That is: if they differ in their limbs or in what is commanded, a term or coupling reads a
    signal that nothing provides, or an actuation needs a phase that the oscillator has not.

    Args:
        controller: what drives the body.
        body: the body.
    """
    if isinstance(body, Interface):
        senses, takes, label = body.senses, body.commands, "the interface"
    else:
        senses, takes, label = body.SENSES, body.COMMANDS, f"a {type(body).__name__}"
    if controller.limbs != body.limbs:
        raise TegotaeError(
            f"the controller drives {controller.limbs} limbs, and {label} has {body.limbs}; each "
            "limb needs one unit"
        )
    commands = controller.actuation.COMMANDS
    if commands != takes:
        raise TegotaeError(
            f"{type(controller.actuation).__name__} commands {' and '.join(commands)}, and {label} "
            f"takes {' and '.join(takes)}"
        )
    oscillator = controller.oscillator
    readable = {*senses, *(() if oscillator is None else oscillator.SIGNALS)}
    reads = {f"{role} term": term.reads for role, term in controller.terms.items()}
    if oscillator is not None:
        reads["oscillator"] = oscillator.READS
    if controller.coupling is not None:
        reads["coupling"] = controller.coupling.READS
    for reader, names in reads.items():
        available = readable | {"feedback"} if reader == "actuation term" else readable
        for name in names:
            if name not in available:
                raise TegotaeError(
                    f"the {reader} reads {name!r}, which nothing provides; "
                    f"known here: {', '.join(sorted(available))}"
                )
    if controller.actuation.needs_phase and (oscillator is None or not oscillator.has_phase):
        message = (
            "no oscillator" if oscillator is None else f"{type(oscillator).__name__}, without one"
        )
        raise TegotaeError(
            f"{type(controller.actuation).__name__} needs a phase, and the controller has {message}"
        )
