"""An action term that is a Fourier series of the phase."""

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae import Experiment, System
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    Reflex,
    Signals,
    Term,
    VanillaReaction,
)


@dataclass(frozen=True)
class FourierAction(Term):
    """`A′(φ) = Σ_n a_n cos nφ + b_n sin nφ`; the weights are a_1, b_1, a_2, b_2, ..."""

    order: int = 3

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the signals that are read."""
        return ("sin_phase", "cos_phase")

    @property
    def n_weights(self) -> int:
        """How many numbers are trained."""
        return 2 * self.order

    def initial(self, key: jax.Array) -> jax.Array:
        """Where training starts: near the vanilla action -cos φ."""
        weights = 0.1 * jax.random.normal(key, (self.n_weights,))
        return weights.at[0].add(-1.0)

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """The term's value: one array of the shape of the lanes."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        sin_n, cos_n = sine, cosine
        value = jnp.zeros_like(sine)
        for n in range(self.order):
            a, b = weights[2 * n], weights[2 * n + 1]
            value = value + a * cos_n + b * sin_n
            # The angle sum gives the next harmonic.
            sin_n, cos_n = sin_n * cosine + cos_n * sine, cos_n * cosine - sin_n * sine
        return value


experiment = Experiment(
    name="fourier",
    system=System(
        controller=Controller(
            Reflex(), PhaseOscillator(), Tegotae(FourierAction(), VanillaReaction(), ConstantGain())
        ),
        omega=8.0,
        timing=EPISODE,
    ),
)
"""What `tegotae train fourier_action.py:experiment` trains."""
