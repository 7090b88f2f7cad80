"""Motion of a rigid trunk: heights of its hips, flight and stance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from math import factorial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number

LARGEST_TURN_RAD = 0.1
"""Rate of a law times the tick [rad] up to which `series` is as exact as said."""
_REMAINDER = {"float32": 1e-7, "float64": 1e-10}
"""Relative tolerance of the velocity in a tick, by dtype."""
ORDER = {
    dtype: next(n for n in count(1) if LARGEST_TURN_RAD**n / factorial(n) < remainder)
    for dtype, remainder in _REMAINDER.items()
}
"""Its order: the velocity leaves out (rate·tick)ⁿ/n!, most at the longest tick. For the paper's
hopper at 1 ms it is 1e-13 in float32."""
_NEWTON_STEPS = 2


def series(derivatives: Sequence[jax.Array], time_s: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Return the position and velocity after a time: the Taylor series from the derivatives at its
    start.

    With derivatives up to `ORDER`, and rates below 0.1 rad per tick, the remainder is below 1e-7 of
    the motion in float32, 1e-10 in float64. Unlike the closed form it needs no case distinction
    between under- and overdamped legs, and adds small increments to x and v, which float32 rounds
    less.
    """
    order = len(derivatives) - 1
    x = v = derivatives[-1]
    for n in range(order, 0, -1):
        x = derivatives[n - 1] + (time_s / n) * x
    for n in range(order - 1, 0, -1):
        v = derivatives[n] + (time_s / n) * v
    return x, v


class Motion(NamedTuple):
    """A motion from its start on."""

    start: Sequence[jax.Array]
    """Position, velocity and acceleration at the start; more derivatives may follow."""
    after: Callable[[jax.Array], tuple[jax.Array, jax.Array]]
    """Position and velocity after a time [s]."""

    @classmethod
    def linear(cls, derivatives: Sequence[jax.Array]) -> Motion:
        """Return the motion of which the derivatives are known up to `ORDER`."""
        return cls(derivatives, partial(series, derivatives))

    @classmethod
    def integrated(
        cls, acceleration: Callable[..., jax.Array], x: jax.Array, v: jax.Array
    ) -> Motion:
        """Return the motion of an acceleration a(x, ẋ, t), by a step of the classical Runge-Kutta
        method.

        Its local error is of fifth order in the time, where the acceleration is smooth.
        """

        def after(time_s: jax.Array) -> tuple[jax.Array, jax.Array]:
            half = 0.5 * time_s
            second = acceleration(x + half * v, v + half * first, half)
            third = acceleration(x + half * (v + half * first), v + half * second, half)
            fourth = acceleration(x + time_s * (v + half * second), v + time_s * third, time_s)
            return (
                x + time_s * (v + (time_s / 6.0) * (first + second + third)),
                v + (time_s / 6.0) * (first + 2.0 * (second + third) + fourth),
            )

        first = acceleration(x, v, 0.0)
        return cls([x, v, first], after)


def crossing_time(motion: Motion, tick_s: jax.Array) -> jax.Array:
    """Time in [0, tick] at which a motion first crosses x = 0, where it is known to do so.

    The root of the motion at constant acceleration (exact in undamped flight) is the start of two
    Newton steps on the true motion.
    """
    x, v, acceleration = motion.start[:3]
    at_crossing = jnp.sqrt(jnp.maximum(v * v - 2.0 * acceleration * x, 0.0))
    # Stance (x < 0) is left upwards, flight downwards; this form of the root does not cancel.
    denominator = v + jnp.where(x < 0.0, at_crossing, -at_crossing)
    time = jnp.clip(-2.0 * x / jnp.where(denominator == 0.0, 1.0, denominator), 0.0, tick_s)
    for _ in range(_NEWTON_STEPS):
        x_at, v_at = motion.after(time)
        time = jnp.clip(time - x_at / jnp.where(v_at == 0.0, 1.0, v_at), 0.0, tick_s)
    return time


def rise(
    x0: jax.Array, v0: jax.Array, x1: jax.Array, v1: jax.Array, time_s: jax.Array
) -> jax.Array:
    """Return the height climbed [m] between two states less than a tick apart, ∫ max(0, ẏ) dt.

    Where the velocity changes sign on the way, it is taken as linear in time.
    """
    turns = (v0 > 0.0) != (v1 > 0.0)
    fastest = jnp.maximum(v0, v1)
    rising_s = time_s * fastest / jnp.where(turns, jnp.abs(v1 - v0), 1.0)
    return jnp.where(turns, 0.5 * fastest * rising_s, jnp.maximum(x1 - x0, 0.0))


class Turn(NamedTuple):
    """A way in which a frame turns by an angle q: J q̈ = Σ x_i F_i - K q, J = j n m a²."""

    name: str
    """Name of the turn, such as "pitch"."""
    arms_m: Sequence[float]
    """Rise of each hip with the angle x_i [m/rad]."""
    reach_m: float
    """The distance a from the axis [m] which makes the inertia a ratio."""
    inertia_ratio: float
    """j = J / (n m a²)."""
    stiffness_nm_per_rad: float = 0.0
    """Stiffness K against the angle [N m/rad]."""


class Law(NamedTuple):
    """The linear law of legs in stance or in flight, d being the height over touchdown:

    F = push + rise·t - stiffness·d - damping·ḋ, a force of each leg, arrays [limbs, lanes], or
    the acceleration of a hopper, [lanes].
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
    def from_turns(
        cls, turns: Sequence[Turn], total_mass_kg: float, gravity_m_per_s2: float, like: jax.Array
    ) -> FrameModes:
        """Return the frame that turns in these ways, for lanes as in `like`."""

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
        """Return the motion of the hips for a motion of the modes, [modes, lanes] to [limbs,
        lanes]."""
        return sum((c * q[None] for c, q in zip(self.arms[1:], modes[1:], strict=True)), modes[:1])

    def motion(self, law: Law, place: jax.Array, rate: jax.Array) -> list[jax.Array]:
        """Return the modes and their derivatives, as many as `series` needs, each [modes,
        lanes].
        """
        derivatives = [place, rate]
        for n in range(ORDER[place.dtype.name] - 1):
            displaced, faster = derivatives[n:]
            force = -law.stiffness * self.hips(displaced) - law.damping * self.hips(faster)
            if n < 2:
                force = force + (law.push, law.rise)[n]
            pull = (self.arms * force[None]).sum(axis=1) - self.stiffness * displaced
            derivatives.append(pull / self.inertia - (self.gravity if n == 0 else 0.0))
        return derivatives


def in_heave(heave: jax.Array, turns: int) -> jax.Array:
    """Return modes whose heave alone is not zero: [lanes] to [modes, lanes]."""
    return jnp.stack([heave] + [jnp.zeros_like(heave)] * turns)
