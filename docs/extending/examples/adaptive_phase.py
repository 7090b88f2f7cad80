"""A phase oscillator whose frequency follows its feedback."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae import Experiment, System
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts import require_finite
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.maths import wrap_phase
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.terms import (
    ConstantGain,
    Network,
    Reflex,
    VanillaAction,
)


class AdaptiveState(NamedTuple):
    """Phase φ [rad] and shift of the frequency a [rad/s]."""

    phase: jax.Array
    shift: jax.Array


@dataclass(frozen=True)
class AdaptivePhase(Oscillator):
    """`φ̇ = ω + a + f`, `τ ȧ = η f - a`."""

    strength: float = 0.5
    """How far lasting feedback shifts the frequency, η."""
    time_s: float = 2.0
    """Time constant τ [s]."""

    def __post_init__(self) -> None:
        require_finite("strength", self.strength)
        require_finite("time_s", self.time_s, above=0.0)

    def start(self, phase_rad: jax.Array) -> AdaptiveState:
        """The state at this phase."""
        return AdaptiveState(wrap_phase(phase_rad), jnp.zeros_like(phase_rad))

    def rate(self, state, omega, feedback) -> tuple[jax.Array, ...]:
        """One derivative for each entry of the state."""
        _, shift = state
        return omega + shift + feedback, (self.strength * feedback - shift) / self.time_s

    def phase(self, state) -> jax.Array:
        """φ, not wrapped."""
        return state[0]

    def settle(self, state) -> AdaptiveState:
        """The state as it is kept between ticks: φ in [0, 2π)."""
        return AdaptiveState(wrap_phase(state[0]), state[1])


experiment = Experiment(
    name="adaptive",
    system=System(
        controller=Controller(
            Reflex(),
            AdaptivePhase(),
            Tegotae(VanillaAction(), Network(("spring_force",), hidden=4), ConstantGain()),
        ),
        omega=8.0,
        timing=EPISODE,
    ),
)
"""What `tegotae train adaptive_phase.py:experiment` trains."""
