"""How fast a body comes ahead, where it looks.

Two speeds ahead are in use, and a third has no direction. `speed_ahead_m_per_s` turns with the
body: what a gait keeps under a disturbance. `speed_along_heading_m_per_s` keeps the direction in
which the body looked when the window began: what training wants. `Coordination.speed_m_per_s` is
the distance over ground, as the crow flies, over whole strides: what a cost of transport refers to.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.simulation.recorder import Trajectory

HEADING = ("time_s", "x_m", "y_m", "yaw_rad")
"""The channels from which it follows."""


def speed_ahead_m_per_s(trajectory: Trajectory, first: int) -> jax.Array:
    """Mean speed from a frame on, in the direction in which the body looks [m/s], [lanes].

    `v = Σ (Δx cos ψ + Δy sin ψ) / T`, frame by frame: of who walks backwards it is negative, and
    who walks in a circle is as fast as who walks straight.

    Args:
        trajectory: which has the channels `HEADING`, [frames, lanes].
        first: the frame.

    Example:
        >>> there = {"x_m": jnp.array([[0.0], [2.0]]), "y_m": jnp.zeros((2, 1))}
        >>> back = {"time_s": jnp.array([[0.0], [4.0]]), "yaw_rad": jnp.full((2, 1), jnp.pi)}
        >>> speed_ahead_m_per_s(Trajectory(**there, **back), 0).tolist()
        [-0.5]
    """
    time, x, y, looks = (jnp.asarray(getattr(trajectory, name))[first:] for name in HEADING)
    ahead = jnp.diff(x, axis=0) * jnp.cos(looks[:-1]) + jnp.diff(y, axis=0) * jnp.sin(looks[:-1])
    return ahead.sum(axis=0) / (time[-1] - time[0])


def speed_along_heading_m_per_s(trajectory: Trajectory, first: int) -> jax.Array:
    """Mean speed from a frame on, in the direction in which the body looks then [m/s], [lanes].

    `v = (Δx cos ψ + Δy sin ψ) / T` with ψ at that frame: who turns or drifts is slower.

    Args:
        trajectory: which has the channels `HEADING`, [frames, lanes].
        first: the frame.

    Example:
        >>> there = {"x_m": jnp.array([[0.0], [2.0]]), "y_m": jnp.zeros((2, 1))}
        >>> late = {"time_s": jnp.array([[0.0], [4.0]]), "yaw_rad": jnp.array([[0.0], [3.0]])}
        >>> speed_along_heading_m_per_s(Trajectory(**there, **late), 0).tolist()
        [0.5]
    """
    t = trajectory
    time = t.time_s[-1] - t.time_s[first]
    looks = t.yaw_rad[first]
    ahead = (t.x_m[-1] - t.x_m[first]) * jnp.cos(looks)
    return (ahead + (t.y_m[-1] - t.y_m[first]) * jnp.sin(looks)) / time
