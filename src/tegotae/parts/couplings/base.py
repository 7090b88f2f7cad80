"""What a coupling between the oscillators of several limbs must offer."""

from __future__ import annotations

from abc import ABC, abstractmethod

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Weights
from tegotae.parts.terms.base import Signals
from tegotae.parts.weight_names import WeightName, numbered


class Coupling(ABC):
    """What each oscillator gets from those of the other limbs: a frozen dataclass.

    No coupling at all is Tegotae control's own way: what couples the limbs is the body. Everything
    else in a controller is elementwise; a coupling alone may look across the limb axis, and even it
    never across lanes.

    Source: of this library; the paper has one limb, and (V) names networks of oscillators as future
    work.
    """

    READS: tuple[str, ...] = ("sin_phase", "cos_phase")
    """Names of the signals that it reads, as for terms."""

    def check(self, limbs: int) -> None:  # noqa: B027 - optional
        """Raise `TegotaeError` if it does not go with so many limbs."""

    def n_weights(self, limbs: int) -> int:
        """How many trained numbers it has for so many limbs."""
        return 0

    def weight_names(self, limbs: int) -> tuple[WeightName, ...]:
        """What each of its weights is, in a controller file and in C; numbers by default."""
        return numbered(self.n_weights(limbs))

    def initial(self, key: jax.Array, limbs: int) -> jax.Array:
        """Weights to start training from, shape [n_weights]: none couples, by default."""
        return jnp.zeros((self.n_weights(limbs),))

    @abstractmethod
    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """The input of each limb's oscillator [rad/s], shape [limbs, ...].

        Args:
            weights: n_weights arrays, each of the shape of the lanes.
            signals: those of all limbs, arrays of shape [limbs, ...].
        """
