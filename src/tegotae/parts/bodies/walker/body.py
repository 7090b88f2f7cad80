"""A torso in space on compliant legs whose feet are commanded to places: it walks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, PerLane, Scalar
from tegotae.parts.bodies.base import Body, Contact, Push, Sensation, for_limbs
from tegotae.parts.bodies.frame import rise
from tegotae.parts.bodies.walker import mechanics
from tegotae.parts.bodies.walker.mechanics import CHANNELS, Vector, WalkerState, vector
from tegotae.parts.bodies.walker.numbers import LOWEST_SHARE, WalkerNumbers
from tegotae.parts.channels import FOOT, Channel
from tegotae.parts.parameters import traceable

_LARGEST_TILT_COS = 0.5
"""A torso that is tilted by more than 60° has fallen."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Walker(WalkerNumbers, Body):  # type: ignore[override] - a property is its max_force_n
    """A rigid torso on massless compliant legs, of any number at any place: biped to hexapod.

    Body axes: x forward, y left, z up, from the centre of mass. With (x_i, y_i) the hip of leg i
    and (u, w) its command (`tegotae.parts.terms.EllipticFoot`), the commanded foot is at

        c_i = (x_i - com_x + u,  y_i - com_y,  -com_z - l0 + w).

    The foot is in contact iff it is below the ground. Its anchor is then where it came down, and
    with p the centre of mass, d = Rᵀ(anchor - p) - c and e its rate for a foot that does not slide,

        F = K∘d + D∘e   in body axes.

    Along the ground's normal N = max(0, F_n) acts; across it F_t min(1, μ N / |F_t|), and the
    anchor slides at (that force - F_t) / D_xy. The torso obeys m p̈ = Σ F + push - m g and Euler's
    equations. No contact solver, no impacts: an ordinary differential equation, by Heun's method,
    in which a leg that touches down or lifts off within a tick acts for its share of it.

    Its work is ∫ |F·ċ + ċ·m c̈ + ċ·d ċ| dt, a leg: the two axes of a command are netted. The mass m
    of a leg and the damping d of its joints, none by default, are in this price alone, and nothing
    limits forces (see "A walker's cost of transport" in docs/legs.md).

    Defaults are the dimensionless quadruped C (l0 = m = g = 1: read m as l0, s as √(l0/g)).

    Raises:
        TegotaeError: for a number out of its range, legs without places, an inertia that no body
            can have, or legs too soft to stand on.

    Source: of this library; the ellipses of its feet and its feedback are Owaki et al.'s
    (`tegotae.parts.terms.EllipticFoot`).

    Example:
        >>> body = Walker()
        >>> body.limbs, round(body.standing_height_m, 3)
        (4, 0.592)
    """

    SENSES = (
        "spring_force",
        "spring_force_rate",
        "pitch",
        "roll",
        "pitch_rate",
        "roll_rate",
        "side_roll",
        "side_roll_rate",
        "end_pitch",
        "side_yaw",
        "speed",
    )
    COMMANDS = FOOT

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of the torso's position and orientation and of its feet."""
        return CHANNELS

    def release(
        self,
        height_m: PerLane,
        velocity_m_per_s: PerLane,
        speed_m_per_s: Number = 0.0,
        roll_rad: Number = 0.0,
        pitch_rad: Number = 0.0,
        yaw_rad: Number = 0.0,
        pitch_rate_rad_per_s: Number = 0.0,
        roll_rate_rad_per_s: Number = 0.0,
    ) -> WalkerState:
        """Return the state at release: the centre of mass over the origin, moving forward at a
        speed [m/s].

        Its height is that over the terrain at the origin.
        """
        zero = jnp.zeros_like(height_m)
        height_m = height_m + self.terrain.height_m(zero, zero)
        attitude = mechanics.from_angles(
            *(zero + angle for angle in (roll_rad, pitch_rad, yaw_rad))
        )
        ahead = mechanics.rotation(attitude).x[0], mechanics.rotation(attitude).y[0]
        of_limbs = jnp.zeros((self.limbs, *zero.shape), zero.dtype)
        state = WalkerState(
            position=jnp.stack([zero, zero, height_m]),
            velocity=jnp.stack([*(speed_m_per_s * a for a in ahead), velocity_m_per_s]),
            attitude=attitude,
            turn=jnp.stack([zero + roll_rate_rad_per_s, zero + pitch_rate_rad_per_s, zero]),
            foot=jnp.stack([of_limbs, of_limbs]),
            stands=of_limbs,
            command=jnp.stack([of_limbs, of_limbs]),
            rate=jnp.stack([of_limbs, of_limbs]),
            slid=of_limbs,
            slip=jnp.stack([of_limbs, of_limbs]),
            push=jnp.stack([zero, zero, zero]),
            twist=jnp.stack([zero, zero, zero]),
            com=mechanics.com_of(self, zero),
        )
        return self.commanded(state, state.command)

    def commanded(self, state: WalkerState, command: jax.Array) -> WalkerState:
        """Return the state with the feet where they are commanded to be; those below the ground
        stand.
        """
        turn = mechanics.rotation(for_limbs(state.attitude))
        foot = turn.to_world(mechanics.commanded_feet(self, state._replace(command=command)))
        place = [x + origin for x, origin in zip(foot, for_limbs(state.position), strict=True)]
        return state._replace(foot=jnp.stack(place[:2]), command=command)

    def sense(self, state: WalkerState, ground_m: jax.Array) -> Sensation:
        """Return the load of each leg's spring K_z d_z [N], its rate at a held command; angles;
        speed.

        Roll and yaw are also felt as a leg's side has them, up and to that side, and pitch as its
        end of the torso has it, up.

        The spring's alone: with the damper's, feedback would feel its own command at once. Networks
        see the load over the weight, angles over one radian, rates over √(g / l0).
        """
        state = mechanics.reloaded(self, state)
        stance = mechanics.stance_of(self, state, ground_m)
        arm, contact, stiffness = stance.arm, stance.contact, for_limbs(self.stiffness_z_n_per_m)
        load = jnp.maximum(stiffness * (arm[2] - stance.feet[2]), 0.0)
        moves = stance.turn.to_body(vector(for_limbs(state.velocity)))
        swings = mechanics.cross(vector(for_limbs(state.turn)), arm)
        rate = -stiffness * (moves[2] + swings[2])
        roll, pitch, yaw = mechanics.angles(state.attitude)
        lateral, front = (
            jnp.sign(mechanics.of_legs(hips, load[0])) for hips in (self.hips_y_m, self.hips_x_m)
        )
        per_leg = partial(jnp.broadcast_to, shape=load.shape)
        rolls, roll_rates, pitches, yaws = map(per_leg, (roll, state.turn[0], pitch, yaw))
        zero = jnp.zeros_like(load)
        turning = self.rate_scale
        return Sensation.from_pairs(
            spring_force=(jnp.where(contact, load, zero), self.weight_n),
            spring_force_rate=(
                jnp.where(contact & (load > 0.0), rate, zero),
                self.weight_n * turning,
            ),
            pitch=(pitches, 1.0),
            roll=(rolls, 1.0),
            pitch_rate=(per_leg(state.turn[1]), turning),
            roll_rate=(roll_rates, turning),
            side_roll=(lateral * rolls, 1.0),
            side_roll_rate=(lateral * roll_rates, turning),
            end_pitch=(-front * pitches, 1.0),
            side_yaw=(lateral * yaws, 1.0),
            speed=(per_leg(moves[0][0]), jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m)),
        )

    def predict(
        self, state: WalkerState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[WalkerState, jax.Array, jax.Array]:
        """Return the state one tick on at the accelerations of the last one, feet on their way."""
        state = mechanics.reloaded(self, state)
        mean = state.turn + 0.5 * tick_s * state.twist
        guess = state._replace(
            position=state.position + tick_s * (state.velocity + 0.5 * tick_s * state.push),
            velocity=state.velocity + tick_s * state.push,
            attitude=mechanics.unit(
                state.attitude + tick_s * mechanics.turned(state.attitude, vector(mean))
            ),
            turn=state.turn + tick_s * state.twist,
            foot=state.foot + tick_s * state.slip,
            command=force_n,
        )
        none = jnp.zeros_like(state.slid)
        return guess, none, none + 1.0

    def advance(
        self, state: WalkerState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[WalkerState, Contact]:
        """Return the state one tick on, the feet on their way to where they are commanded to be."""
        state = mechanics.reloaded(self, state)
        aim = push.mean_n
        rate = (aim - state.command) / tick_s
        beginning = mechanics.leg_forces(self, state, rate, ground_m)
        slower = mechanics.gyration(self, state.turn)
        lift, spin = mechanics.accelerations(self, beginning.force, beginning.torque, slower)
        turns = mechanics.turned(state.attitude, vector(state.turn))
        ahead = state._replace(
            position=state.position + tick_s * state.velocity,
            velocity=state.velocity + tick_s * lift,
            attitude=mechanics.unit(state.attitude + tick_s * turns),
            turn=state.turn + tick_s * spin,
            foot=_slid(beginning.stance.anchor, beginning.slip, tick_s),
            stands=_as_shares(beginning.stance.contact, state.stands),
            command=aim,
        )
        ending = mechanics.leg_forces(self, ahead, rate, ground_m)
        # Where in the tick a foot comes down or lifts off; what has no such moment is a mean.
        crosses = beginning.stance.contact != ending.stance.contact
        falls = beginning.stance.clearance - ending.stance.clearance
        share = jnp.where(crosses, beginning.stance.clearance / jnp.where(crosses, falls, 1.0), 0.5)
        share = jnp.clip(share, 0.0, 1.0)

        def mean(first: Iterable[jax.Array], second: Iterable[jax.Array]) -> list[jax.Array]:
            return [share * a + (1.0 - share) * b for a, b in zip(first, second, strict=True)]

        lift, spin = mechanics.accelerations(
            self,
            vector(mean(beginning.force, ending.force)),
            vector(mean(beginning.torque, ending.torque)),
            0.5 * (slower + mechanics.gyration(self, ahead.turn)),
        )
        velocity = state.velocity + tick_s * lift
        turns = 0.5 * (turns + mechanics.turned(ahead.attitude, vector(ahead.turn)))
        slips = mean(beginning.slip, ending.slip)
        # A foot that came down stands where it met the ground.
        touches = ending.stance.contact & ~beginning.stance.contact
        landing = mean(ending.stance.place[:2], beginning.stance.place[:2])
        begun = [
            jnp.where(touches, b, a) for a, b in zip(beginning.stance.anchor, landing, strict=True)
        ]
        end = WalkerState(
            position=state.position + 0.5 * tick_s * (state.velocity + velocity),
            velocity=velocity,
            attitude=mechanics.unit(state.attitude + tick_s * turns),
            turn=state.turn + tick_s * spin,
            foot=_slid(begun, slips, tick_s),
            stands=_as_shares(ending.stance.contact, state.stands),
            command=aim,
            rate=rate,
            slid=state.slid + tick_s * jnp.sqrt(slips[0] ** 2 + slips[1] ** 2),
            slip=jnp.stack(ending.slip),
            push=lift,
            twist=spin,
            com=state.com,
        )
        of_body = vector(mean(beginning.of_body, ending.of_body))
        stance = jnp.where(
            beginning.stance.contact,
            jnp.where(ending.stance.contact, 1.0, share),
            jnp.zeros_like(share),
        )
        z0, z1 = state.position[2], end.position[2]
        v0, v1 = state.velocity[2], end.velocity[2]
        climb = rise(z0, v0, z1, v1, tick_s)
        flies = ~(beginning.stance.contact | ending.stance.contact).any(axis=0)
        apex = flies & (v0 > 0.0) & (v1 <= 0.0)
        to_apex = v0 / jnp.where(apex, v0 - v1, 1.0)
        return end, Contact(
            stance_share=jnp.where(touches, 1.0 - share, stance),
            work_j=self.leg_work(of_body, state.rate, rate, tick_s),
            climb_flight_m=jnp.where(flies, climb, 0.0),
            climb_m=climb,
            apex_share=jnp.where(apex, jnp.clip(to_apex, 0.0, 1.0), jnp.nan),
            apex_height_m=jnp.where(apex, z0 + 0.5 * v0 * to_apex * tick_s, jnp.nan),
            touchdown_share=jnp.where(touches, share, jnp.nan),
            force_n=mean([beginning.load], [ending.load])[0],
        )

    def leg_work(
        self, force_n: Vector, previous_rate: jax.Array, rate: jax.Array, tick_s: jax.Array
    ) -> jax.Array:
        """Return the work of each leg in a tick [J], [limbs, lanes]; its two axes are netted.

        Args:
            force_n: mean force on the torso in body axes [N], [limbs, lanes] each.
            previous_rate: rate of the command in the tick before [m/s], [2, limbs, lanes].
            rate: in this one.
            tick_s: control tick [s].
        """
        along, _, down = force_n
        swing = mechanics.swing_work(self, previous_rate, rate, tick_s)
        return swing - tick_s * (along * rate[0] + down * rate[1])

    def apply_impulse(self, state: WalkerState, impulse_ns: jax.Array) -> WalkerState:
        """A blow on the centre of mass changes its vertical velocity by impulse / m."""
        climb = state.velocity[2] + impulse_ns / self.mass_kg
        return state._replace(velocity=state.velocity.at[2].set(climb))

    def failed(self, state: WalkerState, ground_m: jax.Array) -> jax.Array:
        """Return True for a torso that lies: tilted by more than 60°, or with its mass near the
        ground.
        """
        x, y, z = state.position
        low = LOWEST_SHARE * (self.rest_length_m + self.com_z_m)
        tilts = mechanics.rotation(state.attitude).z[2] < _LARGEST_TILT_COS
        return tilts | (z - self.terrain.height_m(x, y) - ground_m < low)

    def height(self, state: WalkerState) -> jax.Array:
        return state.position[2]

    def velocity(self, state: WalkerState) -> jax.Array:
        return state.velocity[2]

    def energy(self, state: WalkerState, ground_m: jax.Array) -> jax.Array:
        """½ m v² + ½ ω·I ω + m g z + ½ Σ d·K d over the feet on the ground [J]."""
        stance = mechanics.stance_of(self, state, ground_m)
        legs = zip(mechanics.springs_of(self)[0], stance.arm, stance.feet, strict=True)
        springs = sum(k * (r - c) ** 2 for k, r, c in legs)
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        turns = sum(j * w**2 for j, w in zip(inertia, state.turn, strict=True))
        return (
            0.5 * self.mass_kg * (state.velocity**2).sum(axis=0)
            + 0.5 * turns
            + self.weight_n * state.position[2]
            + 0.5 * jnp.where(stance.contact, springs, 0.0).sum(axis=0)
        )


def _slid(anchor: Sequence[jax.Array], slip: Sequence[jax.Array], time_s: Scalar) -> jax.Array:
    """Return the anchors after sliding for a time, [2, limbs, lanes]."""
    return jnp.stack([a + time_s * s for a, s in zip(anchor, slip, strict=True)])


def _as_shares(holds: jax.Array, like: jax.Array) -> jax.Array:
    return holds.astype(like.dtype)
