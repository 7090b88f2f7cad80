"""The controller held over the tick: what a sampled controller on a robot does."""

from __future__ import annotations

from dataclasses import dataclass

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

    A foot that is commanded to a place is on its way there during the tick (`Push`).
    """

    def tick(self, controller, body, weights, omega, moment, ground_m, tick_s):
        """One tick; see `Integrator.tick`."""
        now = drive(controller, body, weights, omega, moment.body, moment.oscillator, ground_m)
        oscillator = held(moment.oscillator, now.rate, tick_s)
        phase = phase_of(controller, moment.oscillator, now.feedback)
        force = push(controller, largest_force(body), now.command, phase, phase, omega)
        force = to_limbs(controller, force)
        state, contact = body.advance(moment.body, force, ground_m, tick_s)
        return Moment(state, oscillator, now, moment.drive), contact, force
