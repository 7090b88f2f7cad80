"""How the torso of a walker moves under the forces of its legs."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.parts.bodies.attitude import (
    Vector,
    cross,
    rotation,
    vector,
)
from tegotae.parts.bodies.walker.numbers import WalkerNumbers
from tegotae.parts.bodies.walker.state import WalkerState


def reloaded(numbers: WalkerNumbers, state: WalkerState) -> WalkerState:
    """The state after a load has been shifted: the torso stays, its centre of mass moves."""
    com = com_of(numbers, jnp.zeros_like(state.position[0]))
    shift = vector(com - state.com)
    moves = cross(vector(state.turn), shift)
    turn = rotation(state.attitude)
    return state._replace(
        position=state.position + jnp.stack(turn.to_world(shift)),
        velocity=state.velocity + jnp.stack(turn.to_world(moves)),
        com=com,
    )


def gyration(numbers: WalkerNumbers, turn: jax.Array) -> jax.Array:
    """-ω x I ω [N m], [3, lanes]."""
    x, y, z = turn
    inertia = numbers.inertia_x_kg_m2, numbers.inertia_y_kg_m2, numbers.inertia_z_kg_m2
    spin = inertia[0] * x, inertia[1] * y, inertia[2] * z
    return -jnp.stack(cross((x, y, z), spin))


def accelerations(
    numbers: WalkerNumbers, force: Vector, torque: Vector, gyration: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Of the centre of mass [m/s²] and of the turn [rad/s²], both [3, lanes]."""
    pushes = numbers.push_x_n, numbers.push_y_n, numbers.push_z_n - numbers.weight_n
    inertia = numbers.inertia_x_kg_m2, numbers.inertia_y_kg_m2, numbers.inertia_z_kg_m2
    lift = [(f.sum(axis=0) + p) / numbers.mass_kg for f, p in zip(force, pushes, strict=True)]
    spin = [(t.sum(axis=0) + g) / j for t, g, j in zip(torque, gyration, inertia, strict=True)]
    return jnp.stack(lift), jnp.stack(spin)


def com_of(numbers: WalkerNumbers, like: jax.Array) -> jax.Array:
    """Where the centre of mass is in the torso [m], [3, lanes]."""
    return jnp.stack([like + x for x in (numbers.com_x_m, numbers.com_y_m, numbers.com_z_m)])
