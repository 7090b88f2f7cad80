"""What an oscillator must offer so that Tegotae feedback can entrain it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import jax


class Oscillator(ABC):
    """A rhythm generator with a phase: a frozen dataclass without state of its own.

    Its state is a tuple of arrays of the shape of the lanes, passed in and out; every method is
    elementwise.
    """

    @abstractmethod
    def start(self, phase_rad: jax.Array) -> tuple[jax.Array, ...]:
        """The state at phase `phase_rad` [rad]."""

    @abstractmethod
    def rate(
        self, state: tuple[jax.Array, ...], omega: jax.Array, feedback: jax.Array
    ) -> tuple[jax.Array, ...]:
        """Time derivative of the state, given ω and the Tegotae feedback f [rad/s]."""

    @abstractmethod
    def phase(self, state: tuple[jax.Array, ...]) -> jax.Array:
        """The phase φ [rad]; it may be unwrapped within one control tick."""

    @abstractmethod
    def sin_cos(self, state: tuple[jax.Array, ...]) -> tuple[jax.Array, jax.Array]:
        """Sine and cosine of the phase."""

    def settle(self, state: tuple[Any, ...]) -> tuple[Any, ...]:
        """The same state, in the form kept between ticks (such as a phase wrapped to [0, 2π))."""
        return state
