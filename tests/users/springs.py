"""Hoppers of a user on other springs, each by one method."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae import Hopper, register
from tegotae.parts.parameters import traceable


@register
@traceable
@dataclass(frozen=True, kw_only=True)
class Hertz(Hopper):
    """A contact of two spheres, `F_k = k d^1.5`."""

    def spring(self, depth):
        """Return F_k [N] at a depth d [m]."""
        return self.stiffness_n_per_m * depth**1.5


@register
@traceable
@dataclass(frozen=True, kw_only=True)
class Softening(Hopper):
    """A spring that gives way, `F_k = k d / (1 + d / s)` with s = 1 m."""

    def spring(self, depth):
        """Return F_k [N] at a depth d [m]."""
        return self.stiffness_n_per_m * depth / (1.0 + depth)


@register
@traceable
@dataclass(frozen=True, kw_only=True)
class Proportional(Hopper):
    """The hopper's spring, written once more."""

    def spring(self, depth):
        """Return F_k [N] at a depth d [m]."""
        return self.stiffness_n_per_m * depth
