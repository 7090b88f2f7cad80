"""Where legs are on a body, and the heading of a walk."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.simulation.recorder import Trajectory

_ROWS = {1: ("",), 2: ("H", "F"), 3: ("H", "M", "F")}


def names_of(forward_m: ArrayLike, left_m: ArrayLike) -> tuple[str, ...]:
    """Names of legs from the places of their hips: LH, LF, RH, RF, as Hildebrand has them.

    L and R are left and right, H, M and F hind, middle and fore. Without a left and a right, as on
    a bar, or without hind and fore, as on a biped, that letter is left out. Legs that such letters
    do not distinguish are numbered from 1 on, in their order.

    Args:
        forward_m: how far forward of the middle each hip is, [limbs].
        left_m: how far to the left, [limbs].

    Raises:
        TegotaeError: for places that are not as many.

    Source:
        Hildebrand, Symmetrical gaits of horses, Science 150 (1965).

    Example:
        >>> names_of((-1, -1, 1, 1), (1, -1, 1, -1))
        ('LH', 'RH', 'LF', 'RF')
        >>> names_of((-0.5, 0.5), (0, 0)), names_of((0, 0), (0.1, -0.1))
        (('H', 'F'), ('L', 'R'))
        >>> names_of((-1, -0.3, 0.3, 1), (0, 0, 0, 0))
        ('1', '2', '3', '4')
    """
    forward, left = np.asarray(forward_m, float), np.asarray(left_m, float)
    if forward.ndim != 1 or forward.shape != left.shape:
        raise TegotaeError(
            f"hips have {forward.size} places along the body and {left.size} across it; each needs "
            "one of both"
        )
    rows = np.unique(forward.round(6))
    sides = np.sign(left.round(6)).astype(int)
    row_names = _ROWS.get(len(rows))
    names = (
        []
        if row_names is None
        else [
            ("", "L", "R")[side] + row_names[int(np.searchsorted(rows, at))]
            for side, at in zip(sides, forward.round(6), strict=True)
        ]
    )
    if len(set(names)) == len(forward) and all(names):
        return tuple(names)
    return tuple(str(leg) for leg in range(1, len(forward) + 1))


def reference_leg(names: Sequence[str]) -> int:
    """The leg that lags are measured from: the left hind leg, or the first one without one.

    Example:
        >>> reference_leg(("LF", "RF", "LH", "RH")), reference_leg(("H", "F"))
        (2, 0)
    """
    return list(names).index("LH") if "LH" in names else 0


def leg_names(body: Body) -> tuple[str, ...]:
    """Names of a body's legs, from its hips; numbers, if it does not say where they are.

    Hips are `hips_x_m`, forward, and `hips_y_m`, to the left (or `hips_z_m`, on a plate); or
    `hips_m` along a bar.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> leg_names(Bar())
        ('H', 'F')
    """
    body = unwrapped(body)
    forward = getattr(body, "hips_x_m", getattr(body, "hips_m", None))
    if forward is None:
        return tuple(str(leg) for leg in range(1, body.limbs + 1))
    left = getattr(body, "hips_y_m", getattr(body, "hips_z_m", np.zeros(len(forward))))
    return names_of(forward, left)


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
