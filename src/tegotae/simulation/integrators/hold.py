"""The controller held over the tick: what a sampled controller on a robot does."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.parts._shapes import PerLane, PerLimb, Scalar, Weights
from tegotae.parts.bodies import Body, Contact, Push
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators.base import (
    Integrator,
    Moment,
    drive,
    held,
    largest_force,
    phase_of,
    push,
    to_limbs,
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
