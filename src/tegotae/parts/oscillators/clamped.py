"""An oscillator that does not move: what is left of a controller without its rhythm."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import StateTree, Weights
from tegotae.parts.oscillators.wrapper import OscillatorWrapper


@dataclass(frozen=True)
class Clamped(OscillatorWrapper):
    """An oscillator whose state stays where it starts, `φ̇ = 0`.

    The measure CPGu asks whether a controller hops with the phase held at fixed values.

    Source: paper IV-A, on CPGu.

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> import jax.numpy as jnp
        >>> clamped = Clamped(PhaseOscillator())
        >>> clamped.rate(clamped.start(jnp.ones(1)), jnp.array([5.0]), jnp.array([2.0]))
        PhaseState(phase=Array([0.], dtype=float32))
    """

    def rate(
        self,
        state: StateTree,
        omega: jax.Array,
        feedback: jax.Array,
        weights: Weights = (),
    ) -> StateTree:
        """Zero."""
        return jax.tree.map(jnp.zeros_like, state)

    def decay_per_s(self, omega: float) -> float:
        """None: nothing moves."""
        return 0.0
