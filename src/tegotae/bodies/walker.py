"""A torso in space on compliant legs whose feet are commanded to places: it walks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from tegotae.bodies.attitude import (
    Rotation,
    Vector,
    angles,
    cross,
    dot,
    from_angles,
    rotation,
    turned,
    unit,
    vector,
)
from tegotae.bodies.base import Body, Contact, Push, Sensation, for_limbs
from tegotae.bodies.motion import rise
from tegotae.channels import Channel, State, Total
from tegotae.commands import FOOT
from tegotae.errors import TegotaeError, require_finite
from tegotae.parameters import traceable
from tegotae.terrains import Flat, Terrain

LARGEST_STEP = 0.7
"""Rate of the stiffest motion times the tick [rad] up to which Heun's method holds lags, speed and
cost of transport within one per cent."""
LARGEST_TILT_COS = 0.5
"""A torso that is tilted by more than 60° has fallen."""
LOWEST_SHARE = 0.3
"""So has one whose centre of mass is below this share of its height on legs of full length."""


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


class _Stance(NamedTuple):
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


class _Legs(NamedTuple):
    """What the legs do at one instant, arrays [limbs, lanes]."""

    stance: _Stance
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


@traceable
@dataclass(frozen=True, kw_only=True)
class Walker(Body):
    """A rigid torso on massless compliant legs, of any number at any place: biped to hexapod.

    Body axes: x forward, y left, z up, from the centre of mass. With (x_i, y_i) the hip of leg i
    and (u, w) its command (`tegotae.terms.EllipticFoot`), the commanded foot is at

        c_i = (x_i - com_x + u,  y_i - com_y,  -com_z - l0 + w).

    The foot is in contact iff it is below the ground. Its anchor is then where it came down, and
    with p the centre of mass, d = Rᵀ(anchor - p) - c and e its rate for a foot that does not slide,

        F = K∘d + D∘e   in body axes.

    Along the ground's normal N = max(0, F_n) acts; across it F_t min(1, μ N / |F_t|), and the
    anchor slides at (that force - F_t) / D_xy. The torso obeys m p̈ = Σ F + push - m g and Euler's
    equations. No contact solver, no impacts: an ordinary differential equation, by Heun's method,
    in which a leg that touches down or lifts off within a tick acts for its share of it.

    Defaults are the dimensionless quadruped C (l0 = m = g = 1: read m as l0, s as √(l0/g)).

    Raises:
        TegotaeError: for a number out of its range, legs without places, an inertia that no body
            can have, or legs too soft to stand on.

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
        "speed",
    )
    COMMANDS = FOOT

    hips_x_m: tuple[float, ...] = (0.85, 0.85, -0.85, -0.85)
    """How far forward the hips are, from the middle of the torso [m]."""
    hips_y_m: tuple[float, ...] = (0.44, -0.44, 0.44, -0.44)
    """How far to the left they are [m]."""
    present: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    """1 of a leg that is there, 0 of one that is lost."""
    com_x_m: float = 0.0
    """How far before the middle of the torso its centre of mass is [m]."""
    com_y_m: float = 0.0
    """How far to the left of it [m]."""
    com_z_m: float = -0.39
    """How far above the hips [m]; below them if negative."""
    mass_kg: float = 1.0
    """Mass m [kg]."""
    inertia_x_kg_m2: float = 0.10
    """Moment of inertia in roll [kg m²]."""
    inertia_y_kg_m2: float = 0.24
    """In pitch [kg m²]."""
    inertia_z_kg_m2: float = 0.29
    """In yaw [kg m²]."""
    stiffness_x_n_per_m: float = 10.0
    """Stiffness of a leg fore and aft K_x [N/m]."""
    stiffness_y_n_per_m: float = 3.7
    """Sideways K_y [N/m]."""
    stiffness_z_n_per_m: float = 14.0
    """Up and down K_z [N/m]."""
    damping_xy_ns_per_m: float = 1.3
    """Damping of a leg along the ground D_x = D_y [N s/m]."""
    damping_z_ns_per_m: float = 0.9
    """Up and down D_z [N s/m]."""
    friction: float = 0.8
    """Coefficient of friction μ."""
    rest_length_m: float = 1.0
    """Length of a leg at rest l0 [m]."""
    gravity_m_per_s2: float = 1.0
    """Gravity g [m/s²]."""
    push_x_n: float = 0.0
    """External force on the centre of mass, in the world's x [N]."""
    push_y_n: float = 0.0
    """In its y [N]."""
    push_z_n: float = 0.0
    """Upwards [N]."""
    terrain: Terrain = field(default_factory=Flat)
    """The ground."""

    def __post_init__(self) -> None:
        self._check_numbers()
        self._check_legs()
        self._check_inertia()
        standing = sum(self.present)
        sag = self.weight_n / (standing * self.stiffness_z_n_per_m)
        height = self.rest_length_m + self.com_z_m
        if sag >= (1.0 - LOWEST_SHARE) * height:
            raise TegotaeError(
                f"stiffness_z_n_per_m is {self.stiffness_z_n_per_m:g}: {standing:g} legs give way "
                f"by {sag:.3g} m under this weight, and the centre of mass is {height:.3g} m high; "
                f"it must be more than {sag / (1.0 - LOWEST_SHARE) / height:.2g} times that"
            )

    def _check_numbers(self) -> None:
        positive = ("mass", "inertia", "stiffness", "rest", "gravity", "damping_xy")
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(each.default, tuple) or each.name == "terrain":
                continue
            if each.name.startswith(positive):
                require_finite(each.name, value, above=0.0)
            elif each.name.startswith(("damping", "friction")):
                require_finite(each.name, value, least=0.0)
            else:
                require_finite(each.name, value)
        if not isinstance(self.terrain, Terrain):
            raise TegotaeError(f"terrain is {self.terrain!r}; it must be a Terrain, such as Flat()")
        if self.com_z_m <= -self.rest_length_m:
            raise TegotaeError(
                f"com_z_m is {self.com_z_m:g}, which is on the ground under hips of "
                f"{self.rest_length_m:g} m; it must be higher than {-self.rest_length_m:g}"
            )

    def _check_legs(self) -> None:
        for name in ("hips_x_m", "hips_y_m", "present"):
            value = getattr(self, name)
            if not isinstance(value, Iterable):
                raise TegotaeError(f"{name} is {value!r}; it must have a number for each leg")
            object.__setattr__(self, name, tuple(value))
            for number in getattr(self, name):
                require_finite(f"an entry of {name}", number)
        if len(self.hips_x_m) < 2 or len(self.hips_x_m) != len(self.hips_y_m):
            raise TegotaeError(
                f"hips_x_m places {len(self.hips_x_m)} legs and hips_y_m {len(self.hips_y_m)}; "
                "each leg needs both, and there must be two legs or more"
            )
        if self.present == (1.0,) * 4:  # the default, of however many legs
            object.__setattr__(self, "present", (1.0,) * self.limbs)
        if len(self.present) != self.limbs or not set(self.present) <= {0.0, 1.0}:
            raise TegotaeError(
                f"present is {self.present}; it must be 1 or 0 for each of {self.limbs} legs"
            )
        if sum(self.present) < 1:
            raise TegotaeError(f"present is {self.present}; at least one leg must be there")

    def _check_inertia(self) -> None:
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        if 2.0 * max(inertia) > sum(inertia) * (1.0 + 1e-6):
            raise TegotaeError(
                f"the moments of inertia are {inertia} kg m², which no body has: none of them can "
                "be larger than the two others together"
            )

    @property
    def limbs(self) -> int:
        """How many legs there are, the lost ones counted."""
        return len(self.hips_x_m)

    @property
    def weight_n(self) -> float:
        """Weight m g [N]."""
        return self.mass_kg * self.gravity_m_per_s2

    @property
    def max_force_n(self) -> float:
        """The weight, by which forces of this body are told: its actuators have no limit [N]."""
        return self.weight_n

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l0) [rad/s]."""
        return jnp.sqrt(self.gravity_m_per_s2 / self.rest_length_m)

    @property
    def touching_height_m(self) -> Any:
        """Height of the centre of mass over legs at rest, l0 + com_z [m]."""
        return self.rest_length_m + self.com_z_m

    @property
    def standing_height_m(self) -> float:
        """Height at which it stands with no command: l0 + com_z - m g / (n K_z) [m]."""
        sag = self.weight_n / (sum(self.present) * self.stiffness_z_n_per_m)
        return self.rest_length_m + self.com_z_m - sag

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Where it is and how it lies, and what its feet do."""
        return CHANNELS

    def check_tick(self, tick_s: float) -> None:
        """Raise `TegotaeError` if a control tick is too long for the legs' springs and dampers."""
        fastest = self._fastest_rad_per_s
        if fastest * tick_s > LARGEST_STEP:
            raise TegotaeError(
                f"the control tick of {tick_s:g} s is too long for this walker, whose stance has a "
                f"rate of {fastest:.3g} rad/s; use at most {LARGEST_STEP / fastest:.2g} s"
            )

    @property
    def _fastest_rad_per_s(self) -> float:
        """A bound of the rates of stance: all legs on the ground, each mode by itself."""
        reach_x = max(abs(x - self.com_x_m) for x in self.hips_x_m)
        reach_y = max(abs(y - self.com_y_m) for y in self.hips_y_m)
        height = self.rest_length_m + self.com_z_m

        def fastest(x: float, y: float, z: float) -> float:
            rates = (
                x / self.mass_kg,
                y / self.mass_kg,
                z / self.mass_kg,
                (z * reach_y**2 + y * height**2) / self.inertia_x_kg_m2,
                (z * reach_x**2 + x * height**2) / self.inertia_y_kg_m2,
                (x * reach_y**2 + y * reach_x**2) / self.inertia_z_kg_m2,
            )
            return self.limbs * max(rates)

        along, down = self.damping_xy_ns_per_m, self.damping_z_ns_per_m
        springs = self.stiffness_x_n_per_m, self.stiffness_y_n_per_m, self.stiffness_z_n_per_m
        return max(math.sqrt(fastest(*springs)), fastest(along, along, down))

    def release(
        self,
        height_m,
        velocity_m_per_s,
        speed_m_per_s=0.0,
        roll_rad=0.0,
        pitch_rad=0.0,
        yaw_rad=0.0,
        pitch_rate_rad_per_s=0.0,
        roll_rate_rad_per_s=0.0,
    ) -> WalkerState:
        """State at release: the centre of mass over the origin, moving forward at a speed [m/s]."""
        zero = jnp.zeros_like(height_m)
        attitude = from_angles(*(zero + angle for angle in (roll_rad, pitch_rad, yaw_rad)))
        ahead = rotation(attitude).x[0], rotation(attitude).y[0]
        of_limbs = jnp.zeros((self.limbs, *zero.shape), zero.dtype)
        state = WalkerState(
            position=jnp.stack([zero, zero, height_m]),
            velocity=jnp.stack([*(speed_m_per_s * a for a in ahead), velocity_m_per_s]),
            attitude=attitude,
            turn=jnp.stack([zero + roll_rate_rad_per_s, zero + pitch_rate_rad_per_s, zero]),
            foot=jnp.stack([of_limbs, of_limbs]),
            stands=of_limbs,
            command=jnp.stack([of_limbs, of_limbs]),
            slid=of_limbs,
            slip=jnp.stack([of_limbs, of_limbs]),
            push=jnp.stack([zero, zero, zero]),
            twist=jnp.stack([zero, zero, zero]),
            com=self._com(zero),
        )
        return self.commanded(state, state.command)

    def commanded(self, state: WalkerState, command: jax.Array) -> WalkerState:
        """The state with the feet where they are commanded to be; those below the ground stand."""
        turn = rotation(for_limbs(state.attitude))
        foot = turn.to_world(self._feet(state._replace(command=command)))
        place = [x + at for x, at in zip(foot, for_limbs(state.position), strict=True)]
        return state._replace(foot=jnp.stack(place[:2]), command=command)

    def _com(self, like: jax.Array) -> jax.Array:
        return jnp.stack([like + x for x in (self.com_x_m, self.com_y_m, self.com_z_m)])

    def _of_legs(self, values: Any, like: jax.Array) -> jax.Array:
        """A number of each leg as [limbs, lanes]."""
        rows = [jnp.broadcast_to(x, like.shape).astype(like.dtype) for x in values]
        return jnp.stack(rows)

    def _feet(self, state: WalkerState) -> Vector:
        """The commanded feet in body axes c_i [m]."""
        of_legs = partial(self._of_legs, like=state.position[0])
        forward, up = state.command
        return (
            of_legs(self.hips_x_m) - for_limbs(self.com_x_m) + forward,
            of_legs(self.hips_y_m) - for_limbs(self.com_y_m) + jnp.zeros_like(up),
            up - for_limbs(self.com_z_m) - for_limbs(self.rest_length_m),
        )

    def _ground(self, x: jax.Array, y: jax.Array, ground_m: jax.Array) -> jax.Array:
        """Height of the ground under the feet [m], [limbs, lanes]."""
        return jax.tree.map(for_limbs, self.terrain).height_m(x, y) + for_limbs(ground_m)

    def _stance(self, state: WalkerState, ground_m: jax.Array) -> _Stance:
        """How the legs stand."""
        turn = rotation(for_limbs(state.attitude))
        feet = self._feet(state)
        centre = for_limbs(state.position)
        x, y, z = (w + p for w, p in zip(turn.to_world(feet), centre, strict=True))
        clearance = z - self._ground(x, y, ground_m)
        present = self._of_legs(self.present, state.position[0]) > 0.5
        stands = state.stands > 0.5
        both = zip(state.foot, (x, y), strict=True)
        ahead, aside = (jnp.where(stands, there, here) for there, here in both)
        up = self._ground(ahead, aside, ground_m)
        arm = turn.to_body((ahead - centre[0], aside - centre[1], up - centre[2]))
        contact = (clearance < 0.0) & present
        return _Stance(turn, feet, (x, y, z), clearance, contact, (ahead, aside), arm)

    def _legs(self, state: WalkerState, rate: jax.Array, ground_m: jax.Array) -> _Legs:
        """What the legs do in this state, while their command changes at this rate [m/s]."""
        stance = self._stance(state, ground_m)
        turn, arm, contact = stance.turn, stance.arm, stance.contact
        moves = turn.to_body(vector(for_limbs(state.velocity)))
        swings = cross(vector(for_limbs(state.turn)), arm)
        commanded = rate[0], jnp.zeros_like(rate[0]), rate[1]
        stiff, damp = self._springs
        x, y, z = (
            stiff[i] * (arm[i] - stance.feet[i]) - damp[i] * (moves[i] + swings[i] + commanded[i])
            for i in range(3)
        )
        borne, load, slip = self._upon(turn.to_world((x, y, z)), stance.anchor)
        zero = jnp.zeros_like(load)
        force = vector([jnp.where(contact, f, zero) for f in borne])
        of_body = turn.to_body(force)
        slides = [jnp.where(contact, s, zero) for s in slip]
        load = jnp.where(contact, load, zero)
        return _Legs(stance, force, of_body, cross(arm, of_body), load, (slides[0], slides[1]))

    @property
    def _springs(self) -> tuple[Vector, Vector]:
        """Stiffness [N/m] and damping [N s/m] of a leg along the body axes."""
        stiff = self.stiffness_x_n_per_m, self.stiffness_y_n_per_m, self.stiffness_z_n_per_m
        damp = self.damping_xy_ns_per_m, self.damping_xy_ns_per_m, self.damping_z_ns_per_m
        return vector(map(for_limbs, stiff)), vector(map(for_limbs, damp))

    def _upon(
        self, force: Vector, anchor: tuple[jax.Array, jax.Array]
    ) -> tuple[Vector, jax.Array, tuple[jax.Array, jax.Array]]:
        """What of a leg's force the ground bears; the load on it; how the anchor slides."""
        slopes = jax.tree.map(for_limbs, self.terrain).slopes(*anchor)
        one, none = jnp.ones_like(force[0]), jnp.zeros_like(force[0])
        normal: Vector = (none, none, one)
        if slopes is not None:
            steep = jax.lax.rsqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
            normal = (-slopes[0] * steep, -slopes[1] * steep, steep)
        across = dot(force, normal)
        load = jnp.maximum(across, 0.0)
        along = vector(f - across * n for f, n in zip(force, normal, strict=True))
        # The share of the force along the ground that friction bears.
        most = for_limbs(self.friction) * load
        share = jnp.minimum(1.0, most * jax.lax.rsqrt(jnp.maximum(dot(along, along), 1e-30)))
        slides = (share - 1.0) / for_limbs(self.damping_xy_ns_per_m)
        borne = vector(load * n + share * t for n, t in zip(normal, along, strict=True))
        return borne, load, (slides * along[0], slides * along[1])

    def sense(self, state: WalkerState, ground_m: jax.Array) -> Sensation:
        """Of each leg the load of its spring K_z d_z [N] and its rate; pitch, roll; the speed.

        The spring's alone: with the damper's, feedback would feel its own command at once. Networks
        see the load over the weight, angles over one radian, rates over √(g / l0).
        """
        stance = self._stance(state, ground_m)
        arm, contact, stiffness = stance.arm, stance.contact, for_limbs(self.stiffness_z_n_per_m)
        load = jnp.maximum(stiffness * (arm[2] - stance.feet[2]), 0.0)
        moves = stance.turn.to_body(vector(for_limbs(state.velocity)))
        swings = cross(vector(for_limbs(state.turn)), arm)
        rate = -stiffness * (moves[2] + swings[2])
        roll, pitch, _ = angles(state.attitude)
        each = partial(jnp.broadcast_to, shape=load.shape)
        zero = jnp.zeros_like(load)
        return Sensation(
            {
                "spring_force": jnp.where(contact, load, zero),
                "spring_force_rate": jnp.where(contact & (load > 0.0), rate, zero),
                "pitch": each(pitch),
                "roll": each(roll),
                "pitch_rate": each(state.turn[1]),
                "roll_rate": each(state.turn[0]),
                "speed": each(moves[0][0]),
            },
            {
                "spring_force": self.weight_n,
                "spring_force_rate": self.weight_n * self.rate_scale,
                "pitch": 1.0,
                "roll": 1.0,
                "pitch_rate": self.rate_scale,
                "roll_rate": self.rate_scale,
                "speed": jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m),
            },
        )

    def predict(
        self, state: WalkerState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[WalkerState, jax.Array, jax.Array]:
        """The state one tick on at the accelerations of the last one, feet on their way."""
        mean = state.turn + 0.5 * tick_s * state.twist
        guess = state._replace(
            position=state.position + tick_s * (state.velocity + 0.5 * tick_s * state.push),
            velocity=state.velocity + tick_s * state.push,
            attitude=unit(state.attitude + tick_s * turned(state.attitude, vector(mean))),
            turn=state.turn + tick_s * state.twist,
            foot=state.foot + tick_s * state.slip,
            command=force_n,
        )
        none = jnp.zeros_like(state.slid)
        return guess, none, none + 1.0

    def advance(
        self, state: WalkerState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[WalkerState, Contact]:
        """The state one tick on, the feet on their way to where they are commanded to be."""
        state = self._reloaded(state)
        aim = push.mean_n
        rate = (aim - state.command) / tick_s
        now = self._legs(state, rate, ground_m)
        slower = self._gyration(state.turn)
        lift, spin = self._accelerations(now.force, now.torque, slower)
        turns = turned(state.attitude, vector(state.turn))
        ahead = state._replace(
            position=state.position + tick_s * state.velocity,
            velocity=state.velocity + tick_s * lift,
            attitude=unit(state.attitude + tick_s * turns),
            turn=state.turn + tick_s * spin,
            foot=_slid(now.stance.anchor, now.slip, tick_s),
            stands=_as_shares(now.stance.contact, state.stands),
            command=aim,
        )
        then = self._legs(ahead, rate, ground_m)
        # Where in the tick a foot comes down or lifts off; what has no such moment is a mean.
        crosses = now.stance.contact != then.stance.contact
        falls = now.stance.clearance - then.stance.clearance
        share = jnp.where(crosses, now.stance.clearance / jnp.where(crosses, falls, 1.0), 0.5)
        share = jnp.clip(share, 0.0, 1.0)

        def mean(first: Iterable[jax.Array], second: Iterable[jax.Array]) -> list[jax.Array]:
            return [share * a + (1.0 - share) * b for a, b in zip(first, second, strict=True)]

        lift, spin = self._accelerations(
            vector(mean(now.force, then.force)),
            vector(mean(now.torque, then.torque)),
            0.5 * (slower + self._gyration(ahead.turn)),
        )
        velocity = state.velocity + tick_s * lift
        turns = 0.5 * (turns + turned(ahead.attitude, vector(ahead.turn)))
        slips = mean(now.slip, then.slip)
        # A foot that came down stands where it met the ground.
        touches = then.stance.contact & ~now.stance.contact
        met = mean(then.stance.place[:2], now.stance.place[:2])
        begun = [jnp.where(touches, b, a) for a, b in zip(now.stance.anchor, met, strict=True)]
        end = WalkerState(
            position=state.position + 0.5 * tick_s * (state.velocity + velocity),
            velocity=velocity,
            attitude=unit(state.attitude + tick_s * turns),
            turn=state.turn + tick_s * spin,
            foot=_slid(begun, slips, tick_s),
            stands=_as_shares(then.stance.contact, state.stands),
            command=aim,
            slid=state.slid + tick_s * jnp.sqrt(slips[0] ** 2 + slips[1] ** 2),
            slip=jnp.stack(then.slip),
            push=lift,
            twist=spin,
            com=state.com,
        )
        along, _, down = mean(now.of_body, then.of_body)
        return end, self._contact(
            state,
            end,
            now,
            then,
            work_j=-tick_s * (along * rate[0] + down * rate[1]),
            load_n=mean([now.load], [then.load])[0],
            share=share,
            tick_s=tick_s,
        )

    def _reloaded(self, state: WalkerState) -> WalkerState:
        """The state after a load has been shifted: the torso stays, its centre of mass moves."""
        com = self._com(jnp.zeros_like(state.position[0]))
        shift = vector(com - state.com)
        moves = cross(vector(state.turn), shift)
        turn = rotation(state.attitude)
        return state._replace(
            position=state.position + jnp.stack(turn.to_world(shift)),
            velocity=state.velocity + jnp.stack(turn.to_world(moves)),
            com=com,
        )

    def _gyration(self, turn: jax.Array) -> jax.Array:
        """-ω x I ω [N m], [3, lanes]."""
        x, y, z = turn
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        spin = inertia[0] * x, inertia[1] * y, inertia[2] * z
        return -jnp.stack(cross((x, y, z), spin))

    def _accelerations(
        self, force: Vector, torque: Vector, gyration: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Of the centre of mass [m/s²] and of the turn [rad/s²], both [3, lanes]."""
        pushes = self.push_x_n, self.push_y_n, self.push_z_n - self.weight_n
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        lift = [(f.sum(axis=0) + p) / self.mass_kg for f, p in zip(force, pushes, strict=True)]
        spin = [(t.sum(axis=0) + g) / j for t, g, j in zip(torque, gyration, inertia, strict=True)]
        return jnp.stack(lift), jnp.stack(spin)

    def _contact(
        self,
        start: WalkerState,
        end: WalkerState,
        now: _Legs,
        then: _Legs,
        *,
        work_j: jax.Array,
        load_n: jax.Array,
        share: jax.Array,
        tick_s: jax.Array,
    ) -> Contact:
        zero = jnp.zeros_like(share)
        stance = jnp.where(now.stance.contact, jnp.where(then.stance.contact, 1.0, share), zero)
        stance = jnp.where(then.stance.contact & ~now.stance.contact, 1.0 - share, stance)
        z0, z1 = start.position[2], end.position[2]
        v0, v1 = start.velocity[2], end.velocity[2]
        climb = rise(z0, v0, z1, v1, tick_s)
        flies = ~(now.stance.contact | then.stance.contact).any(axis=0)
        apex = flies & (v0 > 0.0) & (v1 <= 0.0)
        to_apex = v0 / jnp.where(apex, v0 - v1, 1.0)
        return Contact(
            stance_share=stance,
            work_j=work_j,
            climb_flight_m=jnp.where(flies, climb, 0.0),
            climb_m=climb,
            apex_share=jnp.where(apex, jnp.clip(to_apex, 0.0, 1.0), jnp.nan),
            apex_height_m=jnp.where(apex, z0 + 0.5 * v0 * to_apex * tick_s, jnp.nan),
            touchdown_share=jnp.where(then.stance.contact & ~now.stance.contact, share, jnp.nan),
            force_n=load_n,
        )

    def failed(self, state: WalkerState, ground_m: jax.Array) -> jax.Array:
        """True of a torso that lies: tilted by more than 60°, or with its mass near the ground."""
        x, y, z = state.position
        low = LOWEST_SHARE * (self.rest_length_m + self.com_z_m)
        tilts = rotation(state.attitude).z[2] < LARGEST_TILT_COS
        return tilts | (z - self.terrain.height_m(x, y) - ground_m < low)

    def height(self, state: WalkerState) -> jax.Array:
        """Height of the centre of mass [m]."""
        return state.position[2]

    def velocity(self, state: WalkerState) -> jax.Array:
        """Its vertical velocity [m/s]."""
        return state.velocity[2]

    def energy(self, state: WalkerState, ground_m: jax.Array) -> jax.Array:
        """½ m v² + ½ ω·I ω + m g z + ½ Σ d·K d over the feet on the ground [J]."""
        stance = self._stance(state, ground_m)
        each = zip(self._springs[0], stance.arm, stance.feet, strict=True)
        springs = sum(k * (r - c) ** 2 for k, r, c in each)
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        turns = sum(j * w**2 for j, w in zip(inertia, state.turn, strict=True))
        return (
            0.5 * self.mass_kg * (state.velocity**2).sum(axis=0)
            + 0.5 * turns
            + self.weight_n * state.position[2]
            + 0.5 * jnp.where(stance.contact, springs, 0.0).sum(axis=0)
        )


def _slid(anchor: Sequence[jax.Array], slip: Sequence[jax.Array], time_s: Any) -> jax.Array:
    """Anchors after sliding for a time, [2, limbs, lanes]."""
    return jnp.stack([a + time_s * s for a, s in zip(anchor, slip, strict=True)])


def _as_shares(holds: jax.Array, like: jax.Array) -> jax.Array:
    return holds.astype(like.dtype)


def _state(frame: Any) -> WalkerState:
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
"""What a walker records beside what is recorded of every body."""


def _foot(frame: Any, axis: int) -> jax.Array:
    """Where the feet are: their anchors on the ground, else the commanded places."""
    state, body = _state(frame), frame.body
    stance = body._stance(state, frame.ground_m)
    stands = stance.contact & (state.stands > 0.5)
    ground = body._ground(*stance.anchor, frame.ground_m)
    at = (*stance.anchor, ground)[axis]
    return jnp.where(stands, at, stance.place[axis])
