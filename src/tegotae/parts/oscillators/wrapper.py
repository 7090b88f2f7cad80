"""Oscillators around another one; one clamped at a phase."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import StateTree, Weights
from tegotae.parts.channels import Channel
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.weight_names import WeightName


@dataclass(frozen=True)
class OscillatorWrapper(Oscillator):
    """As the oscillator within; subclasses say what is different.

    Args:
        inner: the oscillator within.
    """

    inner: Oscillator

    @property
    def SIGNALS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        """Those of the oscillator within."""
        return self.inner.SIGNALS

    @property
    def STATE(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        """That of the oscillator within."""
        return self.inner.STATE

    @property
    def channels(self) -> tuple[Channel, ...]:
        """As the oscillator within."""
        return self.inner.channels

    @property
    def n_weights(self) -> int:
        """That of the oscillator within, so that its weights fit."""
        return self.inner.n_weights

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """As the oscillator within."""
        return self.inner.weight_names

    def initial(self, key: jax.Array) -> jax.Array:
        """As the oscillator within."""
        return self.inner.initial(key)

    def start(self, phase_rad: jax.Array, **rest: jax.Array) -> StateTree:
        """As the oscillator within."""
        return self.inner.start(phase_rad, **rest)

    def rate(
        self,
        state: StateTree,
        omega: jax.Array,
        feedback: jax.Array,
        weights: Weights = (),
    ) -> StateTree:
        """As the oscillator within."""
        given = (weights,) if self.inner.n_weights else ()
        return self.inner.rate(state, omega, feedback, *given)

    def phase(self, state: StateTree) -> jax.Array:
        """As the oscillator within."""
        return self.inner.phase(state)

    def sin_cos(self, state: StateTree) -> tuple[jax.Array, jax.Array]:
        """As the oscillator within."""
        return self.inner.sin_cos(state)

    def signals(self, state: StateTree) -> dict[str, jax.Array]:
        """As the oscillator within."""
        return self.inner.signals(state)

    def settle(self, state: StateTree) -> StateTree:
        """As the oscillator within."""
        return self.inner.settle(state)

    def decay_per_s(self, omega: float) -> float:
        """As the oscillator within."""
        return self.inner.decay_per_s(omega)

    @property
    def has_phase(self) -> bool:
        """As the oscillator within."""
        return self.inner.has_phase


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
        self,
        state: StateTree,
        omega: jax.Array,
        feedback: jax.Array,
        weights: Weights = (),
    ) -> StateTree:
        """Zero."""
        return jax.tree.map(jnp.zeros_like, state)

    def decay_per_s(self, omega: float) -> float:
        """None: nothing moves."""
        return 0.0
