"""Stairs."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import require_finite
from tegotae.parts.parameters import traceable
from tegotae.parts.terrains.base import Terrain


@traceable
@dataclass(frozen=True, kw_only=True)
class Steps(Terrain):
    """h = rise · ⌈(x - start) / tread⌉ for x > start, else 0: stairs up, or down if it falls.

    A single step has a tread longer than any walk.

    Raises:
        TegotaeError: for a number that is not finite, or a tread that is not positive.

    Example:
        >>> stairs = Steps(rise_m=0.1, tread_m=0.5, start_m=1.0)
        >>> [round(float(stairs.height_m(x, 0.0)), 1) for x in (0.9, 1.1, 1.6)]
        [0.0, 0.1, 0.2]
    """

    rise_m: float = 0.0
    """How much higher each step is [m]."""
    tread_m: float = 1.0
    """How long each step is [m]."""
    start_m: float = 1.0
    """Where the first one is [m]."""

    def __post_init__(self) -> None:
        require_finite("rise_m", self.rise_m)
        require_finite("tread_m", self.tread_m, above=0.0)
        require_finite("start_m", self.start_m)

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """The height of the step [m]."""
        past = jnp.ceil((x_m - self.start_m) / self.tread_m)
        return self.rise_m * jnp.maximum(past, 0.0)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> None:
        """None: every step is level, and a foot does not stand on an edge."""
        return None
