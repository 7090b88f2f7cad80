"""Flat ground."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts.parameters import traceable
from tegotae.parts.terrains.base import Terrain


@traceable
@dataclass(frozen=True)
class Flat(Terrain):
    """h = 0."""

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Zero."""
        return jnp.zeros_like(x_m)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> None:
        """None: it is level."""
        return None
