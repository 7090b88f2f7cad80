"""Ground under a walker: flat, a slope, steps, rough, slippery on one side, and their sum."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.transforms import jvp
from tegotae.parts.parameters import Part, a_part, finite, not_negative, positive, traceable

A_TERRAIN = "a Terrain, such as Flat()"
"""Description of a terrain in error messages."""


class Terrain(Part, ABC):
    """A ground h(x, y): a frozen dataclass of numbers, made a pytree by `traceable`.

    Its numbers may differ from lane to lane (`Scenario.changes`), so its methods are elementwise.
    Where the ground drops, the whole of it drops (`Scenario.drop_m`).
    """

    @abstractmethod
    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return the height of the ground at a place [m]; x forward, y left [m]."""

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> tuple[jax.Array, jax.Array] | None:
        """∂h/∂x and ∂h/∂y; None of a ground that is level everywhere.

        By default the derivatives of `height_m`.
        """
        ones = jnp.ones_like(x_m)
        _, along = jvp(lambda x: self.height_m(x, y_m), x_m, ones)
        _, across = jvp(lambda y: self.height_m(x_m, y), y_m, ones)
        return along, across

    def grip(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array | None:
        """Return the ground's share of the body's coefficient of friction; None where it is 1
        everywhere.
        """
        return None


@traceable
@dataclass(frozen=True)
class Flat(Terrain):
    """h = 0."""

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Zero."""
        return jnp.zeros_like(x_m)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> None:
        """Return None, since the ground is level."""
        return None


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

    along: float = finite(0.0)
    """Rise per metre forward: the tangent of the angle."""
    across: float = finite(0.0)
    """Rise per metre to the left."""

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return the plane's height [m]."""
        return self.along * x_m + self.across * y_m


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

    rise_m: float = finite(0.0)
    """Rise of each step [m]."""
    tread_m: float = positive(1.0)
    """Length of each step [m]."""
    start_m: float = finite(1.0)
    """Position of the first step [m]."""

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return the height of the step [m]."""
        past = jnp.ceil((x_m - self.start_m) / self.tread_m)
        return self.rise_m * jnp.maximum(past, 0.0)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> None:
        """Return None: every step is level, and a foot does not stand on an edge."""
        return None


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

    rms_m: float = not_negative(0.0)
    """Root mean square of the height [m]."""
    wavelength_m: float = positive(1.0)
    """Typical wavelength [m]."""
    start_m: float = finite(1.0)
    """Position of the beginning [m]."""
    place: float = finite(0.0)
    """Offset into the random ground: any number."""

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return the height of the waves [m]."""
        x, y = x_m / self.wavelength_m, y_m / self.wavelength_m
        waves = sum(
            jnp.sin(2.0 * math.pi / length * (along * x + across * y) + phase * (1.0 + self.place))
            for length, along, across, phase in _WAVES
        )
        begun = jnp.clip(x - self.start_m / self.wavelength_m, 0.0, 1.0)
        return self.rms_m * math.sqrt(2.0 / len(_WAVES)) * begun * waves


@traceable
@dataclass(frozen=True, kw_only=True)
class SplitGrip(Flat):
    """Level ground with less friction to the right of the x axis, y < 0, than to the left.

    Raises:
        TegotaeError: for a share below zero.

    Example:
        >>> import jax.numpy as jnp
        >>> SplitGrip(right=0.25).grip(jnp.zeros(2), jnp.array([-0.4, 0.4])).tolist()
        [0.25, 1.0]
    """

    right: float = not_negative(1.0)
    """Friction on the right as a share of that on the left."""

    def grip(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return the share at a place."""
        return jnp.where(y_m < 0.0, self.right, jnp.ones_like(y_m))


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

    first: Terrain = a_part(Terrain, A_TERRAIN, Flat)
    second: Terrain = a_part(Terrain, A_TERRAIN, Flat)

    def height_m(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array:
        """Return both heights together [m]."""
        return self.first.height_m(x_m, y_m) + self.second.height_m(x_m, y_m)

    def slopes(self, x_m: jax.Array, y_m: jax.Array) -> tuple[jax.Array, jax.Array] | None:
        """Return both slopes together, or None if both grounds are level everywhere."""
        first, second = self.first.slopes(x_m, y_m), self.second.slopes(x_m, y_m)
        if first is None or second is None:
            return second if first is None else first
        return first[0] + second[0], first[1] + second[1]

    def grip(self, x_m: jax.Array, y_m: jax.Array) -> jax.Array | None:
        """Return the product of both shares; None if both grounds hold everywhere."""
        first, second = self.first.grip(x_m, y_m), self.second.grip(x_m, y_m)
        if first is None or second is None:
            return second if first is None else first
        return first * second
