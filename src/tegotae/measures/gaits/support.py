"""Whether the mass of a walker is over the polygon of its feet, and by how much."""

from __future__ import annotations

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Walker


def support_margin_m(body: Walker, lost: tuple[int, ...] = ()) -> float:
    """How far the mass is inside the polygon of the hips of the legs that are there [m].

    The least distance from its sides; negative outside. With three legs a negative margin means
    that no standing is possible with feet below their hips, and a positive one that it is.

    Args:
        body: the walker; of its legs those that are `present` count.
        lost: the numbers of legs that are lost besides.

    Raises:
        TegotaeError: for a leg that there is not, or fewer than three that are left.

    Example:
        >>> support_margin_m(Walker()), round(support_margin_m(Walker(), lost=(2,)), 6)
        (0.44, 0.0)
    """
    for leg in lost:
        if not 0 <= leg < body.limbs:
            raise TegotaeError(f"leg {leg} is lost; this body has the legs 0 ... {body.limbs - 1}")
    left = [k for k in range(body.limbs) if body.present[k] > 0.5 and k not in lost]
    if len(left) < 3:
        raise TegotaeError(f"{len(left)} legs are left; a polygon of support has three or more")
    hips = np.array([body.hips_x_m, body.hips_y_m]).T[left]
    sides = _sides(hips)
    mass = np.array([body.com_x_m, body.com_y_m])
    return min(_left_of(mass, *side) for side in sides)


def _sides(points: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Sides of the convex polygon around points, counter-clockwise: none has a point outside."""
    pairs = [(a, b) for a in points for b in points if not np.array_equal(a, b)]
    return [(a, b) for a, b in pairs if all(_left_of(p, a, b) >= -1e-9 for p in points)]


def _left_of(point: np.ndarray, begin: np.ndarray, end: np.ndarray) -> float:
    """Distance of a point from a line, positive to its left."""
    along = end - begin
    across = along[0] * (point[1] - begin[1]) - along[1] * (point[0] - begin[0])
    return float(across / np.hypot(*along))
