"""An oscillator that can be stopped on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import StateTree
from tegotae.parts.oscillators.wrappers import OscillatorWrapper


@dataclass(frozen=True, eq=False)
class Stoppable(OscillatorWrapper):
    """The oscillator within while `moving`, and `tegotae.parts.oscillators.Clamped` while not.

    Args:
        inner: the oscillator within.
        moving: whether it moves: an array of bools, [lanes].

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> one = jnp.ones(1)
        >>> stopped = Stoppable(PhaseOscillator(), jnp.array([False]))
        >>> float(stopped.rate(stopped.start(one), 5.0 * one, 2.0 * one).phase[0])
        0.0
    """

    moving: jax.Array

    def rate(
        self,
        state: StateTree,
        omega: jax.Array,
        feedback: jax.Array,
        weights: Sequence[jax.Array] = (),
    ) -> StateTree:
        """Return the rate of the wrapped oscillator, or zero."""
        rate = super().rate(state, omega, feedback, weights)
        return jax.tree.map(lambda x: jnp.where(self.moving, x, jnp.zeros_like(x)), rate)
