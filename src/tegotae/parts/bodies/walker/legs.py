"""How the legs of a walker stand, and with what force."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts.bodies.attitude import (
    Rotation,
    Vector,
    cross,
    dot,
    rotation,
    vector,
)
from tegotae.parts.bodies.base import for_limbs
from tegotae.parts.bodies.walker.numbers import WalkerNumbers
from tegotae.parts.bodies.walker.state import WalkerState


class LegStances(NamedTuple):
    """How the legs stand at one instant, arrays [limbs, lanes]."""

    turn: Rotation
    """From body to world axes."""
    feet: Vector
    """The commanded feet c in body axes [m]."""
    place: Vector
    """The same in the world [m]."""
    clearance: jax.Array
    """Their height over the ground [m]."""
    contact: jax.Array
    """Whether they are below it."""
    anchor: tuple[jax.Array, jax.Array]
    """Where the feet stand, x and y [m]."""
    arm: Vector
    """From the centre of mass to there, in body axes [m]."""


class Legs(NamedTuple):
    """What the legs do at one instant, arrays [limbs, lanes]."""

    stance: LegStances
    """How they stand."""
    force: Vector
    """Force on the body in world axes [N]."""
    of_body: Vector
    """The same in body axes [N]."""
    torque: Vector
    """Torque on the body in body axes [N m]."""
    load: jax.Array
    """Force along the ground's normal [N]."""
    slip: tuple[jax.Array, jax.Array]
    """Velocity of the anchors, x and y [m/s]."""


def of_legs(values: Sequence[float], like: jax.Array) -> jax.Array:
    """A number of each leg as [limbs, lanes]."""
    rows = [jnp.broadcast_to(x, like.shape).astype(like.dtype) for x in values]
    return jnp.stack(rows)


def commanded_feet(numbers: WalkerNumbers, state: WalkerState) -> Vector:
    """The commanded feet in body axes c_i [m]."""
    each = partial(of_legs, like=state.position[0])
    forward, up = state.command
    return (
        each(numbers.hips_x_m) - for_limbs(numbers.com_x_m) + forward,
        each(numbers.hips_y_m) - for_limbs(numbers.com_y_m) + jnp.zeros_like(up),
        up - for_limbs(numbers.com_z_m) - for_limbs(numbers.rest_length_m),
    )


def ground_under(
    numbers: WalkerNumbers, x: jax.Array, y: jax.Array, ground_m: jax.Array
) -> jax.Array:
    """Height of the ground under the feet [m], [limbs, lanes]."""
    return jax.tree.map(for_limbs, numbers.terrain).height_m(x, y) + for_limbs(ground_m)


def stance_of(numbers: WalkerNumbers, state: WalkerState, ground_m: jax.Array) -> LegStances:
    """How the legs stand."""
    turn = rotation(for_limbs(state.attitude))
    feet = commanded_feet(numbers, state)
    centre = for_limbs(state.position)
    x, y, z = (w + p for w, p in zip(turn.to_world(feet), centre, strict=True))
    clearance = z - ground_under(numbers, x, y, ground_m)
    present = of_legs(numbers.present, state.position[0]) > 0.5
    stands = state.stands > 0.5
    both = zip(state.foot, (x, y), strict=True)
    ahead, aside = (jnp.where(stands, there, here) for there, here in both)
    up = ground_under(numbers, ahead, aside, ground_m)
    arm = turn.to_body((ahead - centre[0], aside - centre[1], up - centre[2]))
    contact = (clearance < 0.0) & present
    return LegStances(turn, feet, (x, y, z), clearance, contact, (ahead, aside), arm)


def legs_of(
    numbers: WalkerNumbers, state: WalkerState, rate: jax.Array, ground_m: jax.Array
) -> Legs:
    """What the legs do in this state, while their command changes at this rate [m/s]."""
    stance = stance_of(numbers, state, ground_m)
    turn, arm, contact = stance.turn, stance.arm, stance.contact
    moves = turn.to_body(vector(for_limbs(state.velocity)))
    swings = cross(vector(for_limbs(state.turn)), arm)
    commanded = rate[0], jnp.zeros_like(rate[0]), rate[1]
    stiff, damp = springs_of(numbers)
    x, y, z = (
        stiff[i] * (arm[i] - stance.feet[i]) - damp[i] * (moves[i] + swings[i] + commanded[i])
        for i in range(3)
    )
    borne, load, slip = _upon(numbers, turn.to_world((x, y, z)), stance.anchor)
    zero = jnp.zeros_like(load)
    force = vector([jnp.where(contact, f, zero) for f in borne])
    of_body = turn.to_body(force)
    slides = [jnp.where(contact, s, zero) for s in slip]
    load = jnp.where(contact, load, zero)
    return Legs(stance, force, of_body, cross(arm, of_body), load, (slides[0], slides[1]))


def springs_of(numbers: WalkerNumbers) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Stiffness [N/m] and damping [N s/m] of a leg along the body axes."""
    stiff = numbers.stiffness_x_n_per_m, numbers.stiffness_y_n_per_m, numbers.stiffness_z_n_per_m
    damp = numbers.damping_xy_ns_per_m, numbers.damping_xy_ns_per_m, numbers.damping_z_ns_per_m
    return tuple(map(for_limbs, stiff)), tuple(map(for_limbs, damp))


def _upon(
    numbers: WalkerNumbers, force: Vector, anchor: tuple[jax.Array, jax.Array]
) -> tuple[Vector, jax.Array, tuple[jax.Array, jax.Array]]:
    """What of a leg's force the ground bears; the load on it; how the anchor slides."""
    slopes = jax.tree.map(for_limbs, numbers.terrain).slopes(*anchor)
    one, none = jnp.ones_like(force[0]), jnp.zeros_like(force[0])
    normal: Vector = (none, none, one)
    if slopes is not None:
        steep = jax.lax.rsqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
        normal = (-slopes[0] * steep, -slopes[1] * steep, steep)
    across = dot(force, normal)
    load = jnp.maximum(across, 0.0)
    along = vector(f - across * n for f, n in zip(force, normal, strict=True))
    # The share of the force along the ground that friction bears.
    most = for_limbs(numbers.friction) * load
    share = jnp.minimum(1.0, most * jax.lax.rsqrt(jnp.maximum(dot(along, along), 1e-30)))
    slides = (share - 1.0) / for_limbs(numbers.damping_xy_ns_per_m)
    borne = vector(load * n + share * t for n, t in zip(normal, along, strict=True))
    return borne, load, (slides * along[0], slides * along[1])
