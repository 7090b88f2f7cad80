"""The terms of the feedback: action A, reaction R and gain G (paper equations 2 to 5)."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Weights
from tegotae.parts.terms.base import Signals, Term


@dataclass(frozen=True)
class VanillaAction(Term):
    """`A′(φ) = C′(φ) = -cos φ`, from the belief C(φ) = -sin φ that stance has sin φ < 0.

    Source: paper equation 2; the belief is in IV-A.

    Example:
        >>> from tegotae.parts.terms import Signals
        >>> VanillaAction()((), Signals({"cos_phase": jnp.array([1.0, -1.0])})).tolist()
        [-1.0, 1.0]
    """

    READS = ("cos_phase",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-cos φ."""
        return -signals["cos_phase"]


@dataclass(frozen=True)
class OffsetAction(Term):
    """`A′(φ) = -(cos φ + o)` with a trained offset o, the action of the ORC oscillators.

    With the load as reaction and a constant gain it is the law φ̇ = ω - c N (cos φ + o).

    Source: the oscillators of MIT's Biomimetic Robotics Lab's ORCAgym, whose `osc_offset` it is.

    Example:
        >>> OffsetAction().weight_names
        (('offset',),)
    """

    READS = ("cos_phase",)
    WEIGHTS = ("offset",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-(cos φ + o)."""
        return -(signals["cos_phase"] + weights[0])


@dataclass(frozen=True)
class UnitAction(Term):
    """`A′ = 1`: what is sensed reaches the oscillator as it is, `f = G · R(s)` [rad/s].

    Source: of this library; with it a sensed load is a plain input, as of a Matsuoka neuron.
    """

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """1."""
        return jnp.ones_like(next(iter(signals.values.values())))


@dataclass(frozen=True)
class VanillaReaction(Term):
    """`R(s) = S(s) = F_k`, the spring force [N] (paper equation 2 and [24], [30])."""

    READS = ("spring_force",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """F_k [N]."""
        return signals["spring_force"]


@dataclass(frozen=True)
class ConstantGain(Term):
    """`G = σ`, one trained number (paper equation 2).

    With the vanilla terms σ is in rad/(s N).

    Args:
        start: the σ that training starts from.
    """

    WEIGHTS = ("sigma",)

    start: float = 1.0

    def initial(self, key: jax.Array) -> jax.Array:
        """σ = `start`."""
        return jnp.full((1,), self.start)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """σ."""
        return weights[0]
