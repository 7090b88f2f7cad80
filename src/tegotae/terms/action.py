"""Action terms A′(φ): the derivative of the oscillator's belief about the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.terms.base import Signals, Term


@dataclass(frozen=True)
class VanillaAction(Term):
    """`A′(φ) = C′(φ) = -cos φ`, from the belief C(φ) = -sin φ that stance has sin φ < 0 (IV-A)."""

    @property
    def reads(self) -> tuple[str, ...]:
        """The cosine of the phase."""
        return ("cos_phase",)

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """-cos φ."""
        return -signals["cos_phase"]


@dataclass(frozen=True)
class UnitAction(Term):
    """`A′ = 1`: what is sensed reaches the oscillator as it is, an input like any other."""

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """1."""
        return jnp.ones_like(next(iter(signals.values.values())))
