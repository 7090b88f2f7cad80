"""Reaction terms R(s): what the body reports back."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from tegotae.parts._shapes import Weights
from tegotae.parts.terms.base import Signals, Term


@dataclass(frozen=True)
class VanillaReaction(Term):
    """`R(s) = S(s) = F_k`, the spring force [N] (paper equation 2 and [24], [30])."""

    @property
    def reads(self) -> tuple[str, ...]:
        """The spring force."""
        return ("spring_force",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """F_k [N]."""
        return signals["spring_force"]
