"""What an agent's action is to the controller: the one weight of a term that hands it on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import Oscillator, PhaseOscillator
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    Signals,
    Term,
)


@dataclass(frozen=True)
class _One(Term):
    """A term that is 1: `f = G · 1 · 1` leaves the feedback to the gain, which is the agent's."""

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """1."""
        return jnp.ones_like(next(iter(signals.values.values())))


@dataclass(frozen=True)
class CommandedForce(Actuation):
    """An actuator force that is commanded, `F_a = w` [N], with one weight w."""

    @property
    def n_weights(self) -> int:
        """The force itself."""
        return 1

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """w [N]."""
        return weights[0]


def force_controller() -> Controller:
    """The controller whose one weight is the actuator force [N]."""
    return Controller(CommandedForce())


def feedback_controller(actuation: Actuation, oscillator: Oscillator | None = None) -> Controller:
    """The controller whose one weight is the Tegotae feedback f [rad/s].

    An oscillator (the phase oscillator by default) and an actuation without weights make the force
    of it: the agent stands where `G · A′(φ) · R(s)` stood.
    """
    terms = Tegotae(_One(), _One(), ConstantGain())
    return Controller(actuation, oscillator or PhaseOscillator(), terms)
