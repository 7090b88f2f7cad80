"""Attitudes in space: unit quaternions (w, x, y, z) from body axes to world axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import jax
import jax.numpy as jnp

Vector = tuple[jax.Array, jax.Array, jax.Array]
"""Three components, each of any one shape."""


def vector(components: Iterable[jax.Array]) -> Vector:
    """Three components, such as the rows of an array [3, ...]."""
    x, y, z = components
    return x, y, z


class Rotation(NamedTuple):
    """A rotation matrix by its rows: world = R · body."""

    x: Vector
    y: Vector
    z: Vector

    def to_world(self, of_body: Vector) -> Vector:
        """R · v."""
        return (dot(self.x, of_body), dot(self.y, of_body), dot(self.z, of_body))

    def to_body(self, of_world: Vector) -> Vector:
        """Rᵀ · v."""
        a, b, c = of_world
        return vector(x * a + y * b + z * c for x, y, z in zip(*self, strict=True))


def rotation(attitude: jax.Array) -> Rotation:
    """The rotation of a unit quaternion, shape [4, ...]."""
    w, x, y, z = attitude
    return Rotation(
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def turned(attitude: jax.Array, rate: Vector) -> jax.Array:
    """Rate of a quaternion under a turn [rad/s] in body axes: ½ q ⊗ (0, ω)."""
    w, x, y, z = attitude
    a, b, c = rate
    return 0.5 * jnp.stack(
        [
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        ]
    )


def unit(attitude: jax.Array) -> jax.Array:
    """The quaternion at length one."""
    return attitude * jax.lax.rsqrt((attitude * attitude).sum(axis=0, keepdims=True))


def from_angles(roll: jax.Array, pitch: jax.Array, yaw: jax.Array) -> jax.Array:
    """The quaternion of yaw, then pitch, then roll [rad], shape [4, ...].

    With x forward, y left and z up: roll to the right, pitch nose down, yaw to the left.
    """
    (cr, sr), (cp, sp), (cy, sy) = (
        (jnp.cos(0.5 * a), jnp.sin(0.5 * a)) for a in (roll, pitch, yaw)
    )
    return jnp.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def angles(attitude: jax.Array) -> Vector:
    """Roll, pitch and yaw [rad] of a quaternion; the inverse of `from_angles`."""
    x, y, z = rotation(attitude)
    return (
        jnp.arctan2(z[1], z[2]),
        jnp.arcsin(jnp.clip(-z[0], -1.0, 1.0)),
        jnp.arctan2(y[0], x[0]),
    )


def dot(a: Vector, b: Vector) -> jax.Array:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
