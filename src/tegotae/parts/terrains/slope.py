"""A plane that rises."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from tegotae._support.errors import require_finite
from tegotae.parts.parameters import traceable
from tegotae.parts.terrains.base import Terrain


@traceable
@dataclass(frozen=True, kw_only=True)
class Slope(Terrain):
    """h = along · x + across · y.

    Raises:
        TegotaeError: for a number that is not finite.

    Example:
        >>> Slope(along=0.1).height_m(2.0, 0.0)
        0.2
    """

    along: float = 0.0
    """Rise per metre forward: the tangent of the angle."""
    across: float = 0.0
    """Rise per metre to the left."""

    def __post_init__(self) -> None:
        require_finite("along", self.along)
        require_finite("across", self.across)

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """The plane's height [m]."""
        return self.along * x_m + self.across * y_m
