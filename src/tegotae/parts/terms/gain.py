"""Gain terms G: how strongly the feedback moves the oscillator."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Weights
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.weight_names import WeightName


@dataclass(frozen=True)
class ConstantGain(Term):
    """`G = σ`, one trained number (paper equation 2).

    With the vanilla terms σ is in rad/(s N).

    Args:
        start: the σ that training starts from.
    """

    start: float = 1.0

    @property
    def n_weights(self) -> int:
        """σ itself."""
        return 1

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """σ."""
        return (("sigma",),)

    def initial(self, key: jax.Array) -> jax.Array:
        """σ = `start`."""
        return jnp.full((1,), self.start)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """σ."""
        return weights[0]
