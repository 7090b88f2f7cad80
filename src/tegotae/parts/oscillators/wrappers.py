"""Oscillators around another one: held where it starts, or with its own numbers trained."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Number, PerLimb, StateTree, Weights
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.oscillators.planar import Planar
from tegotae.parts.parameters import changed, within
from tegotae.parts.weight_names import WeightName

_SPREAD = 0.3


@dataclass(frozen=True)
class OscillatorWrapper(Oscillator):
    """An oscillator that delegates to another; subclasses override the differences.

    Args:
        inner: the oscillator within.
    """

    inner: Oscillator

    SIGNALS = within("inner")
    STATE = within("inner")
    channels = within("inner")  # type: ignore[override]
    n_weights = within("inner")  # type: ignore[override]
    weight_names = within("inner")  # type: ignore[override]
    initial = within("inner")
    start = within("inner")
    phase = within("inner")
    sin_cos = within("inner")
    signals = within("inner")
    settle = within("inner")
    has_phase = within("inner")  # type: ignore[override]
    decay_per_s = within("inner")

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Delegate to the wrapped oscillator."""
        arguments = (weights,) if self.inner.n_weights else ()
        return self.inner.rate(state, omega, feedback, *arguments)


@dataclass(frozen=True)
class Clamped(OscillatorWrapper):
    """An oscillator whose state stays where it starts, `φ̇ = 0`.

    The measure CPGu asks whether a controller hops with the phase held at fixed values.

    Source: paper IV-A, on CPGu.

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> import jax.numpy as jnp
        >>> clamped = Clamped(PhaseOscillator())
        >>> clamped.rate(clamped.start(jnp.ones(1)), jnp.array([5.0]), jnp.array([2.0]))
        PhaseState(phase=Array([0.], dtype=float32))
    """

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Zero."""
        return jax.tree.map(jnp.zeros_like, state)

    def decay_per_s(self, omega: float) -> float:
        """Return None: nothing moves."""
        return 0.0


@dataclass(frozen=True)
class Learned(OscillatorWrapper):
    """A planar oscillator with its parameters among the trained numbers (`RANGES` of its class).

    A weight w moves a parameter p from its own value p₀, and w = 0 leaves it there. One that has
    bounds stays between them; others go anywhere:

        p = low · (high / low)^S(w + S⁻¹(s₀)),   S(x) = 1 / (1 + e^-x),   p(w = 0) = p₀;
        p = p₀ + w.

    Args:
        inner: the oscillator that training starts from.

    Raises:
        TegotaeError: for an oscillator of another kind, or a parameter not between its bounds.

    Source: of this library; the paper (V) names learnable oscillators as future work.

    Example:
        >>> from tegotae.parts.oscillators import VanDerPol
        >>> learned = Learned(VanDerPol())
        >>> learned.names
        ('pace', 'turn', 'push', 'mu')
        >>> moved = learned.with_weights([0.0, 0.5, 0.0, 9.0])
        >>> round(float(moved.pace), 6), float(moved.turn), round(float(moved.mu), 3)
        (1.0, 1.5, 2.0)
    """

    def __post_init__(self) -> None:
        if not isinstance(self.inner, Planar):
            raise TegotaeError(
                f"a {type(self.inner).__name__} has no numbers to train; Learned takes a Planar "
                "oscillator, such as Hopf()"
            )
        for name, bounds in self._planar.RANGES.items():
            value = getattr(self.inner, name)
            if bounds is not None and not bounds[0] < value < bounds[1]:
                raise TegotaeError(
                    f"{name} is {value:g}; to be trained it must be between {bounds[0]:g} and "
                    f"{bounds[1]:g}"
                )

    @property
    def _planar(self) -> Planar:
        return cast(Planar, self.inner)

    @property
    def names(self) -> tuple[str, ...]:
        """The trained parameters, in the order of the weights."""
        return tuple(self._planar.RANGES)

    @property
    def n_weights(self) -> int:
        """Number of weights: one per parameter."""
        return len(self.names)

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of the parameters' weights."""
        return tuple((name,) for name in self.names)

    def initial(self, key: jax.Array) -> jax.Array:
        """Return weights near the oscillator within: normal, of standard deviation 0.3."""
        return _SPREAD * jax.random.normal(key, (self.n_weights,))

    def with_weights(self, weights: Sequence[Number]) -> Planar:
        """Return the oscillator within, with the parameters from the weights."""
        oscillator = self._planar
        for (name, bounds), weight in zip(oscillator.RANGES.items(), weights, strict=True):
            oscillator = changed(oscillator, name, partial(_moved, bounds=bounds, weight=weight))
        return oscillator

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Return the rate of the wrapped oscillator with the parameters that the weights encode."""
        return self.with_weights(weights).rate(state, omega, feedback)

    def decay_per_s(self, omega: float) -> float:
        """Return the wrapped oscillator's decay rate with each parameter at its upper bound."""
        oscillator = self._planar
        for name, bounds in oscillator.RANGES.items():
            if bounds is not None:
                oscillator = changed(oscillator, name, lambda _, highest=bounds[1]: highest)
        return oscillator.decay_per_s(omega)


def _moved(value: Number, bounds: tuple[float, float] | None, weight: Number) -> Number:
    """A parameter that a weight moves from its own value."""
    if bounds is None:
        return value + weight
    low, high = bounds
    share = math.log(value / low) / math.log(high / low)
    position = jax.nn.sigmoid(weight + math.log(share / (1.0 - share)))
    return low * jnp.exp(math.log(high / low) * position)
