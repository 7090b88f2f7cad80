"""The controller: Tegotae terms, an oscillator and an actuation, put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.errors import require_finite
from tegotae.oscillators import Oscillator
from tegotae.terms.actuation import Actuation
from tegotae.terms.base import Signals, Term

Weights = Sequence[jax.Array]


@dataclass(frozen=True)
class Tegotae:
    """The feedback law `f = G · A′(φ) · R(s)` [rad/s] (paper equation 4).

    Args:
        action: A′(φ).
        reaction: R(s).
        gain: G; a constant σ or a function of phase and senses.
        limit_rad_per_s: L, if the feedback is to saturate smoothly, `f = L tanh(G A′ R / L)`.
            The paper's law has none; an agent's action is bounded (`tegotae.envs`).

    Raises:
        TegotaeError: for a limit that is not positive.
    """

    action: Term
    reaction: Term
    gain: Term
    limit_rad_per_s: float | None = None

    def __post_init__(self) -> None:
        if self.limit_rad_per_s is not None:
            require_finite("limit_rad_per_s", self.limit_rad_per_s, above=0.0)


@dataclass(frozen=True)
class Controller:
    """What drives a body: oscillator, Tegotae feedback and actuation.

    Without `oscillator` and `tegotae` it is the single network that the paper compares with: its
    actuation reads the senses directly.

    The weights of all terms form one flat vector, in the order action, reaction, gain, actuation
    (`layout`). A controller holds no weights and no state, and is hashable: it is the static part
    of a compiled program.

    Example:
        >>> from tegotae.oscillators import PhaseOscillator
        >>> from tegotae.terms import ConstantGain, Reflex, VanillaAction, VanillaReaction
        >>> terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        >>> Controller(Reflex(), PhaseOscillator(), terms).n_weights
        1
    """

    actuation: Actuation
    oscillator: Oscillator | None = None
    tegotae: Tegotae | None = None

    @property
    def terms(self) -> dict[str, Term]:
        """The terms by role, in the order of their weights."""
        t = self.tegotae
        feedback = {} if t is None else {"action": t.action, "reaction": t.reaction, "gain": t.gain}
        return {**feedback, "actuation": self.actuation}

    @property
    def layout(self) -> dict[str, slice]:
        """Where in the weight vector each term's weights lie."""
        slices, start = {}, 0
        for role, term in self.terms.items():
            slices[role] = slice(start, start + term.n_weights)
            start += term.n_weights
        return slices

    @property
    def n_weights(self) -> int:
        """How many trained numbers the controller has."""
        return sum(term.n_weights for term in self.terms.values())

    def initial(self, key: jax.Array) -> jax.Array:
        """Random weights to start training from, shape [n_weights]."""
        keys = jax.random.split(key, len(self.terms))
        parts = [term.initial(k) for term, k in zip(self.terms.values(), keys, strict=True)]
        return jnp.concatenate(parts)

    def feedback(self, weights: Weights, signals: Signals) -> jax.Array:
        """Tegotae feedback `f = G · A′ · R` [rad/s] (equation 4); zero without Tegotae terms."""
        if self.tegotae is None:
            return jnp.zeros_like(next(iter(signals.values.values())))
        at = self.layout
        action = self.tegotae.action(weights[at["action"]], signals)
        reaction = self.tegotae.reaction(weights[at["reaction"]], signals)
        gain = self.tegotae.gain(weights[at["gain"]], signals)
        feedback = gain * action * reaction
        limit = self.tegotae.limit_rad_per_s
        return feedback if limit is None else limit * jnp.tanh(feedback / limit)

    def smooth_force(self, weights: Weights, signals: Signals, max_force_n) -> jax.Array:
        """The part of the actuator force that is no phase sector, clipped to [0, α] [N]."""
        force = self.actuation(weights[self.layout["actuation"]], signals)
        return jnp.clip(force, 0.0, max_force_n)
