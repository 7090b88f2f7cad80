"""The phase oscillator of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, Weights
from tegotae.parts.oscillators.base import Oscillator


class PhaseState(NamedTuple):
    """Phase φ [rad]."""

    phase: jax.Array


@dataclass(frozen=True)
class PhaseOscillator(Oscillator):
    """A single Kuramoto phase oscillator, `φ̇ = ω + f` (paper equation 5; f holds the gain once).

    Args:
        slowest_rad_per_s: optional floor of the phase rate. The paper has none: strong feedback
            may stop or reverse the phase.

    Example:
        >>> import jax.numpy as jnp
        >>> oscillator = PhaseOscillator()
        >>> oscillator.rate(oscillator.start(jnp.zeros(1)), jnp.array([5.0]), jnp.array([-2.0]))
        PhaseState(phase=Array([3.], dtype=float32))
    """

    slowest_rad_per_s: float | None = None

    def start(self, phase_rad: jax.Array) -> PhaseState:
        """State at phase φ [rad]."""
        return PhaseState(maths.wrap_phase(phase_rad))

    def rate(
        self, state: PhaseState, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> PhaseState:
        """φ̇ = ω + f [rad/s]."""
        rate = omega + feedback
        if self.slowest_rad_per_s is not None:
            rate = jnp.maximum(rate, self.slowest_rad_per_s)
        return PhaseState(rate)

    def phase(self, state: PhaseState) -> jax.Array:
        """φ [rad]."""
        return state.phase

    def sin_cos(self, state: PhaseState) -> tuple[jax.Array, jax.Array]:
        """sin φ, cos φ."""
        return maths.sin_cos(state.phase)

    def settle(self, state: PhaseState) -> PhaseState:
        """φ modulo 2π: a growing phase would lose float32 digits."""
        return PhaseState(maths.wrap_phase(state.phase))
