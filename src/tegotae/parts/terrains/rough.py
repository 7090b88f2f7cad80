"""Rough ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import require_finite
from tegotae.parts.parameters import traceable
from tegotae.parts.terrains.base import Terrain

_WAVES = tuple(
    (length, math.cos(angle), math.sin(angle), phase)
    for length, angle, phase in (
        (1.0, 0.1, 0.3),
        (0.71, 1.3, 2.0),
        (1.37, 2.2, 4.1),
        (0.83, 2.9, 5.2),
        (1.19, 0.8, 1.1),
        (0.59, 1.8, 3.3),
    )
)
"""Lengths in wavelengths, directions, phases [rad]: no two in a whole ratio, so that the ground
does not repeat."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Rough(Terrain):
    """Six waves over each other, from all sides: h = rms · √(2/6) Σ sin(k_i · (x, y) + p_i).

    `rms_m` is its root mean square. It rises from flat ground over one wavelength from `start_m`
    on. Other values of `place` are other places of the same ground, which is how lanes meet
    different ones.

    Raises:
        TegotaeError: for a number that is not finite, a height below zero, or a wavelength that is
            not positive.
    """

    rms_m: float = 0.0
    """Root mean square of the height [m]."""
    wavelength_m: float = 1.0
    """Typical wavelength [m]."""
    start_m: float = 1.0
    """Where it begins [m]."""
    place: float = 0.0
    """Which part of the ground: any number."""

    def __post_init__(self) -> None:
        require_finite("rms_m", self.rms_m, least=0.0)
        require_finite("wavelength_m", self.wavelength_m, above=0.0)
        require_finite("start_m", self.start_m)
        require_finite("place", self.place)

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """The height of the waves [m]."""
        x, y = x_m / self.wavelength_m, y_m / self.wavelength_m
        waves = sum(
            jnp.sin(2.0 * math.pi / length * (along * x + across * y) + phase * (1.0 + self.place))
            for length, along, across, phase in _WAVES
        )
        begun = jnp.clip(x - self.start_m / self.wavelength_m, 0.0, 1.0)
        return self.rms_m * math.sqrt(2.0 / len(_WAVES)) * begun * waves
