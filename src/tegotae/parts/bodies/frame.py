"""A rigid frame on upright legs: it heaves and turns, and each hip rises with both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number
from tegotae.parts.bodies.motion import ORDER


class Turn(NamedTuple):
    """A way in which a frame turns by an angle q: J q̈ = Σ x_i F_i - K q, J = j n m a²."""

    name: str
    """What it is called, such as "pitch"."""
    arms_m: Sequence[float]
    """How far each hip rises with the angle x_i [m/rad]."""
    reach_m: float
    """The distance a from the axis [m] which makes the inertia a ratio."""
    inertia_ratio: float
    """j = J / (n m a²)."""
    stiffness_nm_per_rad: float = 0.0
    """Stiffness K against the angle [N m/rad]."""


class Law(NamedTuple):
    """The legs' linear law, each leg in stance or in flight, arrays [limbs, lanes]:

    F_i = push + rise·t - stiffness·d_i - damping·ḋ_i, with d_i the hip's height over touchdown.
    """

    push: jax.Array
    rise: jax.Array
    stiffness: jax.Array
    damping: jax.Array


class FrameModes(NamedTuple):
    """A frame's modes, heave and then its turns: M_m q̈_m = Σ c_im F_i - K_m q_m, less g in heave.

    Hip i is at the height Σ c_im q_m.
    """

    arms: jax.Array
    """c_im, [modes, limbs, lanes]; 1 for heave."""
    inertia: jax.Array
    """M_m: total mass [kg], then moments of inertia [kg m²], [modes, lanes]."""
    stiffness: jax.Array
    """K_m, 0 for heave, [modes, lanes]."""
    gravity: jax.Array
    """g in heave, 0 in turns, [modes, lanes]."""

    @classmethod
    def of(
        cls, turns: Sequence[Turn], total_mass_kg: float, gravity_m_per_s2: float, like: jax.Array
    ) -> FrameModes:
        """The frame that turns in these ways, for lanes as in `like`."""

        def lanes(x: Number) -> jax.Array:
            return jnp.broadcast_to(jnp.asarray(x, like.dtype), like.shape)

        def legs(arms: Sequence[float]) -> jax.Array:
            return jnp.stack([lanes(arm) for arm in arms])

        level = [1.0] * len(turns[0].arms_m)
        turning = [total_mass_kg * turn.inertia_ratio * turn.reach_m**2 for turn in turns]
        resisting = [turn.stiffness_nm_per_rad for turn in turns]
        return cls(
            jnp.stack([legs(arms) for arms in (level, *(turn.arms_m for turn in turns))]),
            jnp.stack([lanes(x) for x in (total_mass_kg, *turning)]),
            jnp.stack([lanes(x) for x in (0.0, *resisting)]),
            in_heave(lanes(gravity_m_per_s2), len(turns)),
        )

    def hips(self, modes: jax.Array) -> jax.Array:
        """What the hips do when the modes do this, [modes, lanes] to [limbs, lanes]."""
        return sum((c * q[None] for c, q in zip(self.arms[1:], modes[1:], strict=True)), modes[:1])

    def motion(self, law: Law, place: jax.Array, rate: jax.Array) -> list[jax.Array]:
        """The modes and their derivatives, as many as `series` needs, each [modes, lanes]."""
        derivatives = [place, rate]
        for n in range(ORDER[place.dtype.name] - 1):
            at, faster = derivatives[n:]
            force = -law.stiffness * self.hips(at) - law.damping * self.hips(faster)
            if n < 2:
                force = force + (law.push, law.rise)[n]
            pull = (self.arms * force[None]).sum(axis=1) - self.stiffness * at
            derivatives.append(pull / self.inertia - (self.gravity if n == 0 else 0.0))
        return derivatives


def in_heave(heave: jax.Array, turns: int) -> jax.Array:
    """Modes of which heave alone is not zero: [lanes] to [modes, lanes]."""
    return jnp.stack([heave] + [jnp.zeros_like(heave)] * turns)
