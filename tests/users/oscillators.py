"""A user's oscillators: one with an amplitude and weights, one without a phase."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts.channels import State
from tegotae.parts.maths import sin_cos, wrap_phase
from tegotae.parts.oscillators import Oscillator


class AmplitudeState(NamedTuple):
    """Phase [rad] and amplitude."""

    phase: jax.Array
    amplitude: jax.Array


@dataclass(frozen=True)
class LearnedAmplitude(Oscillator):
    """`φ̇ = ω + f`, `τ ȧ = 1 + w f / ω - a`: feedback may swell the amplitude, as learned."""

    SIGNALS = ("sin_phase", "cos_phase", "amplitude")

    time_s: float = 0.5

    @property
    def n_weights(self) -> int:
        return 1

    @property
    def channels(self):
        return (State("amplitude", "a.", lambda f: f.lane.moment.oscillator.amplitude),)

    def start(self, phase_rad):
        return AmplitudeState(wrap_phase(phase_rad), jnp.ones_like(phase_rad))

    def rate(self, state, omega, feedback, weights=()):
        (swell,) = weights
        return AmplitudeState(
            omega + feedback, (1.0 + swell * feedback / omega - state.amplitude) / self.time_s
        )

    def phase(self, state):
        return state.phase

    def signals(self, state):
        return {**super().signals(state), "amplitude": state.amplitude}

    def settle(self, state):
        return state._replace(phase=wrap_phase(state.phase))


class RelaxationState(NamedTuple):
    """Activity and recovery."""

    x: jax.Array
    y: jax.Array


@dataclass(frozen=True)
class Relaxation(Oscillator):
    """Van der Pol's oscillator, `ẋ = ω (μ (x - x³/3) - y) + f`, `ẏ = ω x`: it has no phase."""

    SIGNALS = ("activity",)

    sharpness: float = 1.0

    def start(self, phase_rad):
        sine, cosine = sin_cos(phase_rad)
        return RelaxationState(2.0 * cosine, 2.0 * sine)

    def rate(self, state, omega, feedback, weights=()):
        x, y = state
        return RelaxationState(
            omega * (self.sharpness * (x - x**3 / 3.0) - y) + feedback, omega * x
        )

    def signals(self, state):
        return {"activity": state.x}
