"""Motion within a control tick, where the law is linear: its series, its zero, its rise."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from math import factorial

import jax
import jax.numpy as jnp

LARGEST_TURN_RAD = 0.1
"""Rate of a law times the tick [rad] up to which `series` is as exact as said."""
_REMAINDER = {"float32": 1e-7, "float64": 1e-10}
"""What it may leave out of the velocity in a tick, as a share of the motion."""
ORDER = {
    dtype: next(n for n in count(1) if LARGEST_TURN_RAD**n / factorial(n) < remainder)
    for dtype, remainder in _REMAINDER.items()
}
"""Its order: the velocity leaves out (rate·tick)ⁿ/n!, most at the longest tick. For the paper's
hopper at 1 ms it is 1e-13 in float32."""
_NEWTON_STEPS = 2


def series(derivatives: Sequence[jax.Array], time_s: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Position and velocity after a time: the Taylor series from the derivatives at its start.

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


def crossing_time(derivatives: Sequence[jax.Array], tick_s: jax.Array) -> jax.Array:
    """Time in [0, tick] at which a motion first crosses x = 0, where it is known to do so.

    The root of the motion at constant acceleration (exact in undamped flight) is the start of two
    Newton steps on the true motion.
    """
    x, v, acceleration = derivatives[:3]
    at_crossing = jnp.sqrt(jnp.maximum(v * v - 2.0 * acceleration * x, 0.0))
    # Stance (x < 0) is left upwards, flight downwards; this form of the root does not cancel.
    denominator = v + jnp.where(x < 0.0, at_crossing, -at_crossing)
    time = jnp.clip(-2.0 * x / jnp.where(denominator == 0.0, 1.0, denominator), 0.0, tick_s)
    for _ in range(_NEWTON_STEPS):
        x_at, v_at = series(derivatives, time)
        time = jnp.clip(time - x_at / jnp.where(v_at == 0.0, 1.0, v_at), 0.0, tick_s)
    return time


def rise(
    x0: jax.Array, v0: jax.Array, x1: jax.Array, v1: jax.Array, time_s: jax.Array
) -> jax.Array:
    """Height climbed [m] between two states less than a tick apart, ∫ max(0, ẏ) dt.

    Where the velocity changes sign on the way, it is taken as linear in time.
    """
    turns = (v0 > 0.0) != (v1 > 0.0)
    fastest = jnp.maximum(v0, v1)
    rising_s = time_s * fastest / jnp.where(turns, jnp.abs(v1 - v0), 1.0)
    return jnp.where(turns, 0.5 * fastest * rising_s, jnp.maximum(x1 - x0, 0.0))
