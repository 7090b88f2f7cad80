"""A controller that counts in units of its own, as one that counts in SI."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import PerCommand, PerLimb, StateTree, Weights
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators.wrappers import OscillatorWrapper
from tegotae.parts.parameters import within
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.units import Units


@dataclass(frozen=True)
class ScaledTerm(Term):
    """A term in SI: what it reads is over its units u, and its value times a factor c,

        c · T(s / u).

    Args:
        term: T.
        units: u.
        factor: c, what 1 of its value is.
    """

    term: Term
    units: Units
    factor: float = 1.0

    reads = within("term")  # type: ignore[override]
    n_weights = within("term")  # type: ignore[override]
    weight_names = within("term")  # type: ignore[override]

    def __call__(self, weights: Weights, signals: Signals) -> PerCommand:
        """c · T(s / u)."""
        values = {name: x / self.units.value_of(name) for name, x in signals.values.items()}
        scales = {name: x / self.units.value_of(name) for name, x in signals.scales.items()}
        return self.factor * self.term(weights, Signals(values, scales))


@dataclass(frozen=True)
class ScaledFoot(ScaledTerm, Actuation):
    """A place of the foot in SI [m]."""

    COMMANDS = within("term")

    term: Actuation

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return values along the axes that the term commands [m], [axes, limbs, lanes]."""
        return jnp.asarray(super().__call__(weights, signals))

    def paced(self, weights: Weights, command: jax.Array, omega: jax.Array) -> jax.Array:
        """Return this controller at a frequency in SI [rad/s]."""
        return self.term.paced(weights, command, omega * self.units.time_s)


@dataclass(frozen=True)
class ScaledOscillator(OscillatorWrapper):
    """An oscillator that reads signals, in SI: its state but for its rate keeps its own units u.

    Args:
        inner: the oscillator.
        units: u.
    """

    units: Units

    READS = within("inner")

    def rate(
        self,
        state: StateTree,
        omega: PerLimb,
        feedback: PerLimb,
        weights: Weights = (),
        signals: Signals | None = None,
    ) -> StateTree:
        """Return the rate per second."""
        assert signals is not None
        units, arguments = self.units, (weights,) if self.inner.n_weights else ()
        values = {name: signals[name] / units.value_of(name) for name in self.inner.READS}
        frequency, input_rate = units.time_s * omega, units.time_s * feedback
        sensed: dict[str, Any] = {"signals": Signals(values)}
        rate = self.inner.rate(state, frequency, input_rate, *arguments, **sensed)

        def per_second(x: jax.Array) -> jax.Array:
            return x / units.time_s

        return jax.tree.map(per_second, rate)

    def decay_per_s(self, omega: float) -> float:
        """Return the decay rate of the oscillator [1/s]."""
        return self.inner.decay_per_s(omega * self.units.time_s) / self.units.time_s


def in_si(controller: Controller, units: Units) -> Controller:
    """Return a controller of the same weights in SI units, on legs whose feet it places.

    Args:
        controller: what counts in other units.
        units: these.

    Raises:
        TegotaeError: for one that commands a force, is coupled, or whose oscillator has rates of
            its own.

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> from tegotae.parts.terms import EllipticFoot
        >>> placed = in_si(Controller(EllipticFoot(), PhaseOscillator()), Units(length_m=0.3))
        >>> placed.actuation.factor
        0.3
    """
    if controller.actuation.commands_force:
        raise TegotaeError("the wiring has units, and the controller commands no places of feet")
    if controller.coupling is not None:
        raise TegotaeError("the wiring has units, and the oscillators are coupled")
    law, per_s = controller.tegotae, 1.0 / units.time_s
    if law is not None:
        limit = law.limit_rad_per_s
        law = dataclasses.replace(
            law,
            action=ScaledTerm(law.action, units),
            reaction=ScaledTerm(law.reaction, units),
            gain=ScaledTerm(law.gain, units, per_s),
            limit_rad_per_s=None if limit is None else limit * per_s,
        )
    foot = ScaledFoot(controller.actuation, units, units.length_m)
    rhythm = controller.oscillator
    if rhythm is not None:
        rhythm = ScaledOscillator(rhythm, units) if rhythm.READS else rhythm.in_units(units.time_s)
    return dataclasses.replace(controller, actuation=foot, oscillator=rhythm, tegotae=law)
