"""What a terrain must offer so that a body can walk on it."""

from __future__ import annotations

from abc import ABC, abstractmethod

import jax
import jax.numpy as jnp

from tegotae._support.transforms import jvp


class Terrain(ABC):
    """A ground h(x, y): a frozen dataclass of numbers, made a pytree by `traceable`.

    Its numbers may differ from lane to lane (`Scenario.changes`), so its methods are elementwise.
    Where the ground drops, the whole of it drops (`Scenario.drop_m`).
    """

    @abstractmethod
    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Height of the ground at a place [m]; x forward, y left [m]."""

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> tuple[jax.Array, jax.Array] | None:
        """∂h/∂x and ∂h/∂y; None of a ground that is level everywhere.

        By default the derivatives of `height_m`.
        """
        one = jnp.ones_like(x_m)
        _, along = jvp(lambda x: self.height_m(x, y_m), x_m, one)
        _, across = jvp(lambda y: self.height_m(x_m, y), y_m, one)
        return along, across
