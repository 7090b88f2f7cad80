"""Oscillators that turn in a plane: their phase is the angle of their state there. Those of Hopf
and van der Pol."""

from __future__ import annotations

from abc import abstractmethod
from collections import namedtuple
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, StateTree, Weights
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.parameters import finite, not_negative, positive

Ranges = Mapping[str, tuple[float, float] | None]
"""Parameters by name, each with its bounds, or None for any number."""

NEAR = 0.05
"""Radius below which an input turns the state no faster than it does there."""


@dataclass(frozen=True, kw_only=True)
class Planar(Oscillator):
    """An oscillator in polar coordinates (φ, r) of a plane that is scaled to its limit cycle.

    Polar coordinates are exact, and their phase grows without a jump. Feedback f enters as

        φ̇ = … + turn · f + push · f · (b_y cos φ - b_x sin φ) / r
        ṙ = …             + push · f · (b_x cos φ + b_y sin φ)

    `turn` rotates the state, as in the phase oscillator. `push` is an additive input of the
    oscillator's own equations, b being the direction in which that input moves the state. Below
    r = 0.05 the division is by 0.05.

    A subclass is a frozen dataclass with `free`. Its `State` is made of what `STATE` names: a named
    tuple of the phase, the radius, and the rest.

    Args:
        pace: the free-running frequency as a multiple of ω.
        turn: how far feedback turns the state.
        push: how far feedback enters as an input.

    Raises:
        TegotaeError: for numbers out of their range.
    """

    SIGNALS = ("sin_phase", "cos_phase", "radius")
    STATE = ("radius",)

    RANGES: ClassVar[Ranges] = {"pace": (0.5, 2.0), "turn": None, "push": None}
    """Ranges of the parameters that `Learned` trains."""
    State: ClassVar[Any]
    """Its state, (phase, *STATE)."""

    pace: float = finite(1.0, above=0.0, most=10.0)
    turn: float = finite(1.0)
    push: float = finite(0.0)

    def __init_subclass__(cls) -> None:
        cls.State = namedtuple(f"{cls.__name__}State", ("phase", *cls.STATE))  # type: ignore[misc]
        cls.State.__module__, cls.State.__qualname__ = cls.__module__, f"{cls.__qualname__}.State"

    @property
    def on_cycle(self) -> dict[str, float]:
        """Return the state beside the phase at or near the limit cycle, by name."""
        return {"radius": 1.0}

    def start(self, phase_rad: PerLimb, **state: PerLimb) -> StateTree:
        """Return the state at phase φ [rad], at or near the limit cycle apart from the named
        values.
        """
        near = {name: jnp.full_like(phase_rad, value) for name, value in self.on_cycle.items()}
        return self.State(maths.wrap_phase(phase_rad), **{**near, **state})

    @abstractmethod
    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """Time derivative of the state without feedback, at frequency `omega` [rad/s]."""

    def input_axis(self) -> tuple[float, float]:
        """Return the direction b of the input in the plane."""
        return 0.0, 1.0

    def entering(
        self, state: StateTree, sine: jax.Array, cosine: jax.Array, feedback: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Return the feedback's contributions to φ̇ [rad/s] and to ṙ [1/s]."""
        along, across = self.input_axis()
        pushed = self.push * feedback
        turned = pushed * (across * cosine - along * sine) / jnp.maximum(state[1], NEAR)
        return self.turn * feedback + turned, pushed * (along * cosine + across * sine)

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Return the rate of free motion and feedback together."""
        sine, cosine = maths.sin_cos(state[0])
        free = self.free(state, sine, cosine, self.pace * omega)
        turning, growing = self.entering(state, sine, cosine, feedback)
        return free._replace(phase=free.phase + turning, radius=free.radius + growing)

    def phase(self, state: StateTree) -> jax.Array:
        """φ [rad]."""
        return state[0]

    def signals(self, state: StateTree) -> dict[str, jax.Array]:
        """sin φ, cos φ and r."""
        return {**super().signals(state), "radius": state[1]}

    def settle(self, state: StateTree) -> StateTree:
        """φ in [0, 2π) and r ≥ 0: a state that went through the origin is on the other side."""
        through = state.radius < 0.0
        phase = jnp.where(through, state.phase + 0.5 * maths.TWO_PI, state.phase)
        radius = jnp.abs(state.radius)
        return state._replace(phase=maths.wrap_phase(phase), radius=radius)


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
        return self.State(*_hopf_rates(self, state, omega))

    def decay_per_s(self, omega: float) -> float:
        """2 γ μ."""
        return 2.0 * self.recovery_per_s * self.mu


def _hopf_rates(hopf: Hopf, state: StateTree, omega: PerLimb) -> tuple[PerLimb, PerLimb]:
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
        """Return the Hopf oscillator's state at the prescribed frequency."""
        return {**super().on_cycle, "shift_rad_per_s": 0.0}

    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """φ̇ = ω + a, ṙ = γ (μ - r²) r, ȧ = 0."""
        phase, radius = _hopf_rates(self, state, omega)
        return self.State(phase + state.shift_rad_per_s, radius, jnp.zeros_like(radius))

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Return the rate of free motion and feedback together; the frequency learns."""
        turning, _ = self.entering(state, *maths.sin_cos(state[0]), feedback)
        rate = super().rate(state, omega, feedback)
        return rate._replace(shift_rad_per_s=self.learning_per_s * turning)

    def decay_per_s(self, omega: float) -> float:
        """Return the faster decay rate of radius and frequency."""
        return max(super().decay_per_s(omega), self.learning_per_s)


@dataclass(frozen=True, kw_only=True)
class VanDerPol(Planar):
    """A relaxation oscillator, `z̈ = μ (1 - z²) ż - z`, in a time that gives it the frequency ω.

    In the plane x = z/2, y = -ż/2, in which its amplitude of 2 is 1 and it turns to the left,

        ẋ = -κω y,   ẏ = κω (x + μ (1 - 4x²) y),   κ = T(μ) / 2π,

    with the period T (`period_ratio`). In polar coordinates nothing is divided by r:

        φ̇ = κω (1 + μ (1 - 4 r² cos² φ) sin φ cos φ),   ṙ = κω μ (1 - 4 r² cos² φ) r sin² φ.

    φ is the angle in that plane. It goes round once in a period, faster and slower; at μ = 1 from
    0.37 to 2.2 times ω. An input enters ẏ, as a force does.

    Args:
        mu: μ from 0 to 5; 0 is a harmonic oscillator of any amplitude.

    Raises:
        TegotaeError: for numbers out of their range.

    Reference: B. van der Pol, On relaxation-oscillations, Phil. Mag. 2 (1926).

    Example:
        >>> import jax.numpy as jnp
        >>> oscillator = VanDerPol(mu=1.0)
        >>> rate = oscillator.rate(oscillator.start(jnp.zeros(1)), jnp.ones(1), jnp.ones(1))
        >>> f"{rate.phase[0]:.4f}"  # κω + f
        '2.0596'
    """

    RANGES: ClassVar[Ranges] = {**Planar.RANGES, "mu": (0.05, 2.0)}

    mu: float = finite(1.0, least=0.0, most=5.0)

    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """Return the equations in polar coordinates."""
        _, radius = state
        x = radius * cosine
        strain = self.mu * (1.0 - 4.0 * x * x)
        speed = period_ratio(self.mu) * omega
        turning = speed * (1.0 + strain * sine * cosine)
        return self.State(turning, speed * strain * radius * sine * sine)

    def decay_per_s(self, omega: float) -> float:
        """3 μ κ ω, where the amplitude is largest."""
        return float(3.0 * self.mu * period_ratio(self.mu) * self.pace * omega)


def period_ratio(mu: float) -> float:
    """T(μ) / 2π of van der Pol's oscillator, within 0.2 % for μ from 0 to 5.

        T(μ) / 2π = √[(1 + 0.16321 μ² + 0.00254 μ⁴) / (1 + 0.03821 μ²)]

    Fitted to periods of a Runge-Kutta solution of order 8, with 1 + μ²/16 for small μ.

    Example:
        >>> import numpy as np
        >>> np.round(period_ratio(np.array([0.0, 1.0, 3.0])), 3)  # exactly 1, 1.0605, 1.40997
        array([1.   , 1.06 , 1.411])
    """
    square = mu * mu
    rising = 1.0 + 0.16321 * square + 0.00254 * square * square
    return (rising / (1.0 + 0.03821 * square)) ** 0.5
