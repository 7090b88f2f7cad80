"""Mechanics of a walking torso: attitude, state, legs, and what it reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple, cast

import jax
import jax.numpy as jnp

from tegotae.parts.bodies.base import for_limbs
from tegotae.parts.bodies.walker.numbers import WalkerNumbers
from tegotae.parts.channels import Channel, RecordedFrame, State, Total

Vector = tuple[jax.Array, jax.Array, jax.Array]
"""Three components, each of any one shape."""


def vector(components: Iterable[jax.Array]) -> Vector:
    """Return three components, such as the rows of an array [3, ...]."""
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
    """Return the rotation of a unit quaternion, shape [4, ...]."""
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
    """Return the quaternion at length one."""
    return attitude * jax.lax.rsqrt((attitude * attitude).sum(axis=0, keepdims=True))


def from_angles(roll: jax.Array, pitch: jax.Array, yaw: jax.Array) -> jax.Array:
    """Return the quaternion of yaw, then pitch, then roll [rad], shape [4, ...].

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


class WalkerState(NamedTuple):
    """State of the torso and its feet."""

    position: jax.Array
    """Centre of mass in the world [m], [3, lanes]."""
    velocity: jax.Array
    """And its velocity [m/s], [3, lanes]."""
    attitude: jax.Array
    """Unit quaternion from body to world axes, [4, lanes]."""
    turn: jax.Array
    """Rate of turning in body axes [rad/s], [3, lanes]."""
    foot: jax.Array
    """Anchors of the feet on the ground, x and y [m], [2, limbs, lanes]."""
    stands: jax.Array
    """1 of a foot that is on the ground, else 0, [limbs, lanes]."""
    command: jax.Array
    """Commanded positions of the feet relative to their rest positions [m], [2, limbs, lanes]."""
    rate: jax.Array
    """Rate of the command in the last tick [m/s], [2, limbs, lanes]."""
    slid: jax.Array
    """Distance that the feet have slid over the ground [m], [limbs, lanes]."""
    slip: jax.Array
    """Sliding velocity of the feet, x and y [m/s], [2, limbs, lanes]."""
    push: jax.Array
    """Mean acceleration over the last tick [m/s²], [3, lanes]."""
    twist: jax.Array
    """Mean angular acceleration over the last tick [rad/s²], [3, lanes]."""
    com: jax.Array
    """Position of the centre of mass in the torso [m], [3, lanes]."""


def reloaded(numbers: WalkerNumbers, state: WalkerState) -> WalkerState:
    """Return the state after a load has been shifted: the torso stays, its centre of mass moves."""
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
    """Return the accelerations of the centre of mass [m/s²] and of the turn [rad/s²], both [3,
    lanes]."""
    pushes = numbers.push_x_n, numbers.push_y_n, numbers.push_z_n - numbers.weight_n
    inertia = numbers.inertia_x_kg_m2, numbers.inertia_y_kg_m2, numbers.inertia_z_kg_m2
    lift = [(f.sum(axis=0) + p) / numbers.mass_kg for f, p in zip(force, pushes, strict=True)]
    spin = [(t.sum(axis=0) + g) / j for t, g, j in zip(torque, gyration, inertia, strict=True)]
    return jnp.stack(lift), jnp.stack(spin)


def com_of(numbers: WalkerNumbers, like: jax.Array) -> jax.Array:
    """Return the position of the centre of mass in the torso [m], [3, lanes]."""
    return jnp.stack([like + x for x in (numbers.com_x_m, numbers.com_y_m, numbers.com_z_m)])


class LegStances(NamedTuple):
    """Positions and contacts of the legs at one instant, arrays [limbs, lanes]."""

    turn: Rotation
    """Rotation from body to world axes."""
    feet: Vector
    """The commanded feet c in body axes [m]."""
    place: Vector
    """The same in the world [m]."""
    clearance: jax.Array
    """Their height over the ground [m]."""
    contact: jax.Array
    """True for feet below the ground."""
    anchor: tuple[jax.Array, jax.Array]
    """Anchors of the feet, x and y [m]."""
    arm: Vector
    """Vectors from the centre of mass to the anchors, in body axes [m]."""


class Legs(NamedTuple):
    """Forces and velocities of the legs at one instant, arrays [limbs, lanes]."""

    stance: LegStances
    """Positions and contacts of the legs."""
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
    """Return the commanded feet in body axes c_i [m]."""
    per_leg = partial(of_legs, like=state.position[0])
    forward, up = state.command
    return (
        per_leg(numbers.hips_x_m) - for_limbs(numbers.com_x_m) + forward,
        per_leg(numbers.hips_y_m) - for_limbs(numbers.com_y_m) + jnp.zeros_like(up),
        up - for_limbs(numbers.com_z_m) - for_limbs(numbers.rest_length_m),
    )


def _ground_under(
    numbers: WalkerNumbers, x: jax.Array, y: jax.Array, ground_m: jax.Array
) -> jax.Array:
    """Return the height of the ground under the feet [m], [limbs, lanes]."""
    return jax.tree.map(for_limbs, numbers.terrain).height_m(x, y) + for_limbs(ground_m)


def stance_of(numbers: WalkerNumbers, state: WalkerState, ground_m: jax.Array) -> LegStances:
    """Compute positions and contacts of the legs."""
    turn = rotation(for_limbs(state.attitude))
    feet = commanded_feet(numbers, state)
    centre = for_limbs(state.position)
    x, y, z = (w + p for w, p in zip(turn.to_world(feet), centre, strict=True))
    clearance = z - _ground_under(numbers, x, y, ground_m)
    present = of_legs(numbers.present, state.position[0]) > 0.5
    stands = state.stands > 0.5
    axes = zip(state.foot, (x, y), strict=True)
    ahead, aside = (jnp.where(stands, anchor, command) for anchor, command in axes)
    up = _ground_under(numbers, ahead, aside, ground_m)
    arm = turn.to_body((ahead - centre[0], aside - centre[1], up - centre[2]))
    contact = (clearance < 0.0) & present
    return LegStances(turn, feet, (x, y, z), clearance, contact, (ahead, aside), arm)


def leg_forces(
    numbers: WalkerNumbers, state: WalkerState, rate: jax.Array, ground_m: jax.Array
) -> Legs:
    """Compute the legs' forces in this state, while their command changes at this rate [m/s]."""
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
    """Return the stiffness [N/m] and damping [N s/m] of a leg along the body axes."""
    stiff = numbers.stiffness_x_n_per_m, numbers.stiffness_y_n_per_m, numbers.stiffness_z_n_per_m
    damp = numbers.damping_xy_ns_per_m, numbers.damping_xy_ns_per_m, numbers.damping_z_ns_per_m
    return tuple(map(for_limbs, stiff)), tuple(map(for_limbs, damp))


def swing_work(
    numbers: WalkerNumbers, previous_rate: jax.Array, rate: jax.Array, tick_s: jax.Array
) -> jax.Array:
    """Return the work that moves the legs themselves in a tick, Δ ½ ċ·m ċ + ċ·d ċ Δt [J].

    Args:
        numbers: of the walker.
        previous_rate: rate of the command in the tick before [m/s], [2, limbs, lanes].
        rate: in this one.
        tick_s: control tick [s].

    Returns:
        A work a leg, [limbs, lanes].
    """
    mass = numbers.leg_mass_x_kg, numbers.leg_mass_z_kg
    damping = numbers.joint_damping_x_ns_per_m, numbers.joint_damping_z_ns_per_m
    along, up = (
        0.5 * for_limbs(m) * (current**2 - was**2) + tick_s * for_limbs(d) * current**2
        for m, d, was, current in zip(mass, damping, previous_rate, rate, strict=True)
    )
    return along + up


def _upon(
    numbers: WalkerNumbers, force: Vector, anchor: tuple[jax.Array, jax.Array]
) -> tuple[Vector, jax.Array, tuple[jax.Array, jax.Array]]:
    """Return the part of a leg's force that the ground bears, the load, and the anchor's slide."""
    terrain = jax.tree.map(for_limbs, numbers.terrain)
    slopes = terrain.slopes(*anchor)
    ones, none = jnp.ones_like(force[0]), jnp.zeros_like(force[0])
    normal: Vector = (none, none, ones)
    if slopes is not None:
        steep = jax.lax.rsqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
        normal = (-slopes[0] * steep, -slopes[1] * steep, steep)
    across = dot(force, normal)
    load = jnp.maximum(across, 0.0)
    along = vector(f - across * n for f, n in zip(force, normal, strict=True))
    # The share of the force along the ground that friction bears.
    limit = for_limbs(numbers.friction) * load
    if (grip := terrain.grip(*anchor)) is not None:
        limit = limit * grip
    share = jnp.minimum(1.0, limit * jax.lax.rsqrt(jnp.maximum(dot(along, along), 1e-30)))
    slides = (share - 1.0) / for_limbs(numbers.damping_xy_ns_per_m)
    borne = vector(load * n + share * t for n, t in zip(normal, along, strict=True))
    return borne, load, (slides * along[0], slides * along[1])


def _state(frame: RecordedFrame) -> WalkerState:
    return frame.lane.moment.body


CHANNELS: tuple[Channel, ...] = (
    State("x_m", "Centre of mass, forward [m].", lambda f: _state(f).position[0]),
    State("y_m", "Centre of mass, to the left [m].", lambda f: _state(f).position[1]),
    State("roll_rad", "Roll, to the right [rad].", lambda f: angles(_state(f).attitude)[0]),
    State("pitch_rad", "Pitch, nose down [rad].", lambda f: angles(_state(f).attitude)[1]),
    State("yaw_rad", "Yaw, to the left [rad].", lambda f: angles(_state(f).attitude)[2]),
    State("slid_m", "How far the feet have slid [m], a limb.", lambda f: _state(f).slid),
    State("stands", "1 of a foot on the ground, else 0, a limb.", lambda f: _state(f).stands),
    State("foot_x_m", "Where the foot is, forward [m], a limb.", lambda f: _foot(f, 0)),
    State("foot_y_m", "Where the foot is, to the left [m], a limb.", lambda f: _foot(f, 1)),
    State("foot_z_m", "Where the foot is, upwards [m], a limb.", lambda f: _foot(f, 2)),
    Total(
        "stance_s",
        "Total of the time on the ground [s], a limb.",
        lambda t: t.contact.stance_share * t.tick_s,
    ),
)
"""Channels of a walker beside those of every body."""


def _foot(frame: RecordedFrame, axis: int) -> jax.Array:
    """Return the positions of the feet: anchors on the ground, commanded positions in the air."""
    state, body = _state(frame), cast(WalkerNumbers, frame.body)
    stance = stance_of(body, state, frame.ground_m)
    stands = stance.contact & (state.stands > 0.5)
    ahead, aside = stance.anchor
    position = (ahead, aside, _ground_under(body, ahead, aside, frame.ground_m))[axis]
    return jnp.where(stands, position, stance.place[axis])
