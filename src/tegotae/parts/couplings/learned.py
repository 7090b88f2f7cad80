"""Oscillators that learn whom to listen to."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Weights
from tegotae.parts.couplings.base import Coupling
from tegotae.parts.terms.base import Signals
from tegotae.parts.weight_names import WeightName, inside


@dataclass(frozen=True)
class LearnedCoupling(Coupling):
    """A learned matrix of couplings, `Σ_j a_ij sin(φ_j - φ_i) + b_ij cos(φ_j - φ_i)` [rad/s].

    Strength and lag of each pair are `√(a² + b²)` and `atan2(-b, a)`: two weights for every ordered
    pair of different limbs, a then b, limb by limb.

    Source: Kuramoto's coupling (`Neighbours`) with trained strengths and lags.

    Example:
        >>> LearnedCoupling().n_weights(4)
        24
    """

    def n_weights(self, limbs: int) -> int:
        """Two for each ordered pair."""
        return 2 * limbs * (limbs - 1)

    def weight_names(self, limbs: int) -> tuple[WeightName, ...]:
        """Of each ordered pair its a and its b."""
        return inside(("pair",), [(n, x) for n in range(limbs * (limbs - 1)) for x in ("a", "b")])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """The sum over the other limbs."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        limbs = sine.shape[0]
        rows = iter(weights)
        inputs: list[jax.Array] = []
        for to in range(limbs):
            total = jnp.zeros_like(sine[0])
            for of in (other for other in range(limbs) if other != to):
                sin_gap = sine[of] * cosine[to] - cosine[of] * sine[to]
                cos_gap = cosine[of] * cosine[to] + sine[of] * sine[to]
                total = total + next(rows) * sin_gap + next(rows) * cos_gap
            inputs.append(total)
        return jnp.stack(inputs)
