"""The state of a walker."""

from __future__ import annotations

from typing import NamedTuple

import jax


class WalkerState(NamedTuple):
    """Where the torso and its feet are."""

    position: jax.Array
    """Centre of mass in the world [m], [3, lanes]."""
    velocity: jax.Array
    """And its velocity [m/s], [3, lanes]."""
    attitude: jax.Array
    """Unit quaternion from body to world axes, [4, lanes]."""
    turn: jax.Array
    """Rate of turning in body axes [rad/s], [3, lanes]."""
    foot: jax.Array
    """Where the feet on the ground are anchored, x and y [m], [2, limbs, lanes]."""
    stands: jax.Array
    """1 of a foot that is on the ground, else 0, [limbs, lanes]."""
    command: jax.Array
    """Where the feet are commanded to be, from their places at rest [m], [2, limbs, lanes]."""
    slid: jax.Array
    """How far the feet have slid over the ground [m], [limbs, lanes]."""
    slip: jax.Array
    """How fast the feet slide, x and y [m/s], [2, limbs, lanes]."""
    push: jax.Array
    """Mean acceleration over the last tick [m/s²], [3, lanes]."""
    twist: jax.Array
    """Mean angular acceleration over the last tick [rad/s²], [3, lanes]."""
    com: jax.Array
    """Where the centre of mass is in the torso [m], [3, lanes]."""
