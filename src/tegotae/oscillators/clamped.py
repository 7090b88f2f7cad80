"""An oscillator that does not move: what is left of a controller without its rhythm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from tegotae.channels import Channel
from tegotae.oscillators.base import Oscillator
from tegotae.weight_names import WeightName


@dataclass(frozen=True)
class Clamped(Oscillator):
    """An oscillator whose state stays where it starts, `φ̇ = 0`.

    The measure CPGu asks whether a controller hops with the phase held at fixed values.

    Example:
        >>> from tegotae.oscillators import PhaseOscillator
        >>> import jax.numpy as jnp
        >>> clamped = Clamped(PhaseOscillator())
        >>> clamped.rate(clamped.start(jnp.ones(1)), jnp.array([5.0]), jnp.array([2.0]))
        PhaseState(phase=Array([0.], dtype=float32))
    """

    inner: Oscillator

    @property
    def SIGNALS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        """Those of the oscillator within."""
        return self.inner.SIGNALS

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

    def start(self, phase_rad: jax.Array) -> Any:
        """As the oscillator within."""
        return self.inner.start(phase_rad)

    def rate(
        self,
        state: Any,
        omega: jax.Array,
        feedback: jax.Array,
        weights: Sequence[jax.Array] = (),
    ) -> Any:
        """Zero."""
        return jax.tree.map(jnp.zeros_like, state)

    def phase(self, state: Any) -> jax.Array:
        """As the oscillator within."""
        return self.inner.phase(state)

    def sin_cos(self, state: Any) -> tuple[jax.Array, jax.Array]:
        """As the oscillator within."""
        return self.inner.sin_cos(state)

    def signals(self, state: Any) -> dict[str, jax.Array]:
        """As the oscillator within."""
        return self.inner.signals(state)

    def settle(self, state: Any) -> Any:
        """As the oscillator within."""
        return self.inner.settle(state)

    @property
    def has_phase(self) -> bool:
        """As the oscillator within."""
        return self.inner.has_phase
