"""The Hopf oscillator, with a frequency that is given, or one that adapts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, StateTree, Weights
from tegotae.parts.oscillators.planar import Planar, Ranges
from tegotae.parts.parameters import not_negative, positive


@dataclass(frozen=True, kw_only=True)
class Hopf(Planar):
    """The normal form of a Hopf bifurcation: a circle of radius √μ, at frequency ω,

        ẋ = γ (μ - r²) x - ω y,   ẏ = γ (μ - r²) y + ω x,

    that is φ̇ = ω, ṙ = γ (μ - r²) r. Feedback that turns the state makes φ̇ = ω + f: the phase
    oscillator, with an amplitude beside it. An input enters ẏ.

    Args:
        mu: μ, the square of the radius.
        recovery_per_s: γ [1/s]; a disturbed radius returns as exp(-2 γ μ t).

    Raises:
        TegotaeError: for numbers out of their range.

    Reference: A. Pikovsky, M. Rosenblum, J. Kurths, Synchronization, section 7.1.

    Example:
        >>> import jax.numpy as jnp
        >>> hopf = Hopf(mu=4.0)
        >>> hopf.rate(hopf.start(jnp.zeros(1)), jnp.array([5.0]), jnp.array([-2.0]))
        HopfState(phase=Array([3.], dtype=float32), radius=Array([0.], dtype=float32))
    """

    RANGES: ClassVar[Ranges] = {**Planar.RANGES, "recovery_per_s": (1.0, 10.0)}

    mu: float = positive(1.0)
    recovery_per_s: float = positive(4.0)

    @property
    def on_cycle(self) -> dict[str, float]:
        """The radius √μ."""
        return {"radius": self.mu**0.5}

    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """φ̇ = ω, ṙ = γ (μ - r²) r."""
        return self.State(*_of_hopf(self, state, omega))

    def decay_per_s(self, omega: float) -> float:
        """2 γ μ."""
        return 2.0 * self.recovery_per_s * self.mu


def _of_hopf(hopf: Hopf, state: StateTree, omega: PerLimb) -> tuple[PerLimb, PerLimb]:
    """φ̇ = ω and ṙ = γ (μ - r²) r."""
    radius = state.radius
    growing = hopf.recovery_per_s * (hopf.mu - radius * radius) * radius
    return omega * jnp.ones_like(radius), growing


@dataclass(frozen=True, kw_only=True)
class AdaptiveHopf(Hopf):
    """A Hopf oscillator that takes on the frequency of its input.

    Whatever feedback does to the phase it also does, more slowly, to the frequency:

        φ̇ = ω + a + p,   ȧ = η p,

    p being what feedback adds to φ̇. So ω is where the frequency starts. Nothing restores it:
    feedback that holds the phase still (p = -ω - a) wears the frequency down to nothing.

    Args:
        learning_per_s: η [1/s].

    Raises:
        TegotaeError: for numbers out of their range.

    Reference: L. Righetti, J. Buchli, A. J. Ijspeert, Dynamic Hebbian learning in adaptive
    frequency oscillators, Physica D 216 (2006), equations 3 to 5.

    Example:
        >>> import jax.numpy as jnp
        >>> hopf = AdaptiveHopf(learning_per_s=0.5)
        >>> rate = hopf.rate(hopf.start(jnp.zeros(1)), jnp.array([5.0]), jnp.array([-2.0]))
        >>> float(rate.shift_rad_per_s[0])
        -1.0
    """

    STATE = ("radius", "shift_rad_per_s")
    RANGES: ClassVar[Ranges] = {**Hopf.RANGES, "learning_per_s": (0.05, 5.0)}

    learning_per_s: float = not_negative(0.5)

    @property
    def on_cycle(self) -> dict[str, float]:
        """As of the Hopf oscillator, at the prescribed frequency."""
        return {**super().on_cycle, "shift_rad_per_s": 0.0}

    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """φ̇ = ω + a, ṙ = γ (μ - r²) r, ȧ = 0."""
        phase, radius = _of_hopf(self, state, omega)
        return self.State(phase + state.shift_rad_per_s, radius, jnp.zeros_like(radius))

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Free motion and feedback together; the frequency learns."""
        turning, _ = self.entering(state, *maths.sin_cos(state[0]), feedback)
        rate = super().rate(state, omega, feedback)
        return rate._replace(shift_rad_per_s=self.learning_per_s * turning)

    def decay_per_s(self, omega: float) -> float:
        """The faster of radius and frequency."""
        return max(super().decay_per_s(omega), self.learning_per_s)
