"""One ground on top of another."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts.parameters import traceable
from tegotae.parts.terrains.base import Terrain
from tegotae.parts.terrains.flat import Flat


@traceable
@dataclass(frozen=True, kw_only=True)
class Sum(Terrain):
    """h = h₁ + h₂, such as rough ground on a slope.

    Raises:
        TegotaeError: for what is no terrain.

    Example:
        >>> from tegotae.parts.terrains import Slope, Steps
        >>> both = Sum(first=Slope(along=0.1), second=Steps(rise_m=0.5))
        >>> round(float(both.height_m(1.5, 0.0)), 3)
        0.65
    """

    first: Terrain = field(default_factory=Flat)
    second: Terrain = field(default_factory=Flat)

    def __post_init__(self) -> None:
        for terrain in (self.first, self.second):
            if not is_of(terrain, Terrain):
                raise TegotaeError(f"{terrain!r} is no Terrain, such as Flat()")

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Both heights together [m]."""
        return self.first.height_m(x_m, y_m) + self.second.height_m(x_m, y_m)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> tuple[jax.Array, jax.Array] | None:
        """Both slopes together; None if both grounds are level everywhere."""
        first, second = self.first.slopes(x_m, y_m), self.second.slopes(x_m, y_m)
        if first is None or second is None:
            return second if first is None else first
        return first[0] + second[0], first[1] + second[1]
