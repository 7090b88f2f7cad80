"""Hopper legs under one rigid bar: the plainest body whose limbs feel each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.bodies.base import Body, Contact, Push, Sensation
from tegotae.bodies.hopper import Hopper
from tegotae.bodies.motion import LARGEST_TURN_RAD, ORDER, crossing_time, rise, series
from tegotae.channels import Channel, State
from tegotae.errors import TegotaeError, require_finite
from tegotae.parameters import traceable


class BarState(NamedTuple):
    """Heave y [m], its velocity [m/s], pitch θ [rad] and its rate [rad/s]."""

    height: jax.Array
    velocity: jax.Array
    pitch: jax.Array
    pitch_rate: jax.Array


class _Law(NamedTuple):
    """The legs' linear law, each leg in stance or in flight, arrays [limbs, lanes]:

    F_i = push + rise·t - stiffness·d_i - damping·ḋ_i, with d_i the hip's height over touchdown.
    """

    push: jax.Array
    rise: jax.Array
    stiffness: jax.Array
    damping: jax.Array


class _Motion(NamedTuple):
    """Heave over touchdown and pitch, each with its derivatives at one time, arrays [lanes]."""

    heave: list[jax.Array]
    pitch: list[jax.Array]


class _Passed(NamedTuple):
    """What has happened in a tick so far."""

    time: jax.Array
    stance_time: jax.Array
    stance_travel: jax.Array
    climb_flight: jax.Array
    climb: jax.Array
    apex_time: jax.Array
    apex_height: jax.Array


@traceable
@dataclass(frozen=True, kw_only=True)
class Bar(Body):
    """Two to four of the paper's hopper legs, upright under a rigid bar (heave and pitch).

    The hip of leg i is at x_i along the bar, at height `y_i = y + x_i θ`. In stance, y_i < l0 + h,

        F_i = k (l0 + h - y_i) - c ẏ_i + F_a,i,    0 <= F_a,i <= α,

    in flight F_i = 0; and with m the mass per leg, of n legs,

        n m ÿ = Σ F_i - n m g,    J θ̈ = Σ x_i F_i,    J = j n m a²,

    a being half the distance of the outermost hips. The inertia ratio j is the number that counts:
    two legs at j = 1 do not feel each other, and each moves as the hopper does. Released level,
    with all legs alike, the bar is the hopper at any j.

    Raises:
        TegotaeError: for a number out of its range, or hips that are not two to four places around
            the middle.

    Example:
        >>> bar = Bar(inertia_ratio=0.6)
        >>> bar.limbs, round(bar.inertia_kg_m2, 3)
        (2, 0.03)
    """

    SENSES = ("spring_force", "velocity", "height", "pitch", "pitch_rate")

    hips_m: tuple[float, ...] = (-0.5, 0.5)
    """Where along the bar the hips are, from its centre of mass, back to front [m]; mean 0."""
    inertia_ratio: float = 1.0
    """j = J / (n m a²)."""
    mass_kg: float = 0.1
    """Mass of the bar per leg m [kg]."""
    stiffness_n_per_m: float = 5.0
    """Spring stiffness of a leg k [N/m]."""
    damping_ns_per_m: float = 0.2
    """Damping of a leg c [N s/m], in stance."""
    rest_length_m: float = 1.0
    """Rest length of a leg l0 [m]."""
    gravity_m_per_s2: float = 9.81
    """Gravity g [m/s²]."""
    max_force_n: float = 4.0
    """Largest force of an actuator α [N]."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.name == "hips_m":
                continue
            value = getattr(self, field.name)
            if field.name == "damping_ns_per_m":
                require_finite(field.name, value, least=0.0)
            else:
                require_finite(field.name, value, above=0.0)
        if not isinstance(self.hips_m, Iterable):
            raise TegotaeError(
                f"hips_m is {self.hips_m!r}; name two to four places, such as (-0.5, 0.5)"
            )
        object.__setattr__(self, "hips_m", tuple(self.hips_m))
        for hip in self.hips_m:
            require_finite("a hip", hip)
        if not (2 <= self.limbs <= 4 and all(a < b for a, b in pairwise(self.hips_m))):
            raise TegotaeError(
                f"hips_m is {self.hips_m}; name two to four places from back to front, such as "
                "(-0.5, 0.5)"
            )
        if abs(sum(self.hips_m)) > 1e-6 * self.half_span_m:
            raise TegotaeError(
                f"hips_m is {self.hips_m}, whose mean is {sum(self.hips_m) / len(self.hips_m):g}; "
                "it must be 0, for the bar to rest level"
            )

    @property
    def limbs(self) -> int:
        """How many legs there are."""
        return len(self.hips_m)

    @property
    def half_span_m(self) -> float:
        """Half the distance of the outermost hips a [m]."""
        return 0.5 * (self.hips_m[-1] - self.hips_m[0])

    @property
    def total_mass_kg(self) -> float:
        """n m [kg]."""
        return self.limbs * self.mass_kg

    @property
    def inertia_kg_m2(self) -> float:
        """Moment of inertia about the centre of mass J = j n m a² [kg m²]."""
        return self.inertia_ratio * self.total_mass_kg * self.half_span_m**2

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l0) [rad/s]."""
        return jnp.sqrt(self.gravity_m_per_s2 / self.rest_length_m)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Pitch and its rate."""
        return (
            State("pitch_rad", "Pitch θ [rad].", lambda f: f.lane.moment.body.pitch),
            State(
                "pitch_rate_rad_per_s",
                "Pitch rate [rad/s].",
                lambda f: f.lane.moment.body.pitch_rate,
            ),
        )

    def check_tick(self, tick_s: float) -> None:
        """Raise `TegotaeError` if a control tick is too long for the series within it."""
        stiffest = 1.0 + max(hip**2 for hip in self.hips_m) / (
            self.inertia_ratio * self.half_span_m**2
        )
        fastest = max(
            float(stiffest * self.stiffness_n_per_m / self.mass_kg) ** 0.5,
            stiffest * self.damping_ns_per_m / self.mass_kg,
        )
        if fastest * tick_s > LARGEST_TURN_RAD:
            raise TegotaeError(
                f"the control tick of {tick_s:g} s is too long for this bar, whose stance has a "
                f"rate of {fastest:g} rad/s; use at most {LARGEST_TURN_RAD / fastest:.2g} s"
            )

    def check_release(self, height_m: float) -> None:
        """Raise `TegotaeError` if, released level and at rest from this height [m], it cannot hop.

        Level, with all legs alike, every leg with its share of the mass is a hopper.
        """
        own = {field.name for field in fields(Hopper)} & {field.name for field in fields(self)}
        leg = Hopper(**{name: getattr(self, name) for name in own})
        try:
            leg.check_release(height_m)
        except TegotaeError as error:
            raise TegotaeError(f"as a leg of this bar, {error}") from None

    def release(
        self, height_m, velocity_m_per_s, pitch_rad=0.0, pitch_rate_rad_per_s=0.0
    ) -> BarState:
        """State at release: heave, pitch and their rates."""
        rest = (jnp.zeros_like(height_m) + x for x in (pitch_rad, pitch_rate_rad_per_s))
        return BarState(height_m, velocity_m_per_s, *rest)

    def _column(self, like: jax.Array) -> jax.Array:
        """x_i, shape [limbs, lanes]."""
        return jnp.stack([jnp.broadcast_to(x, like.shape).astype(like.dtype) for x in self.hips_m])

    def _over_touchdown(self, state: BarState, ground_m: jax.Array) -> jax.Array:
        """Heights of the hips over touchdown d_i [m], [limbs, lanes]."""
        heave = state.height - (self.rest_length_m + ground_m)
        return heave[None] + self._column(heave) * state.pitch[None]

    def sense(self, state: BarState, ground_m: jax.Array) -> Sensation:
        """Of each leg its spring force [N], its hip's velocity [m/s] and height [m]; the pitch.

        Networks see F_k / (m g), ẏ_i / √(g l0), height / l0, and pitch over the angle at which the
        ends of the bar differ by l0.
        """
        over = self._over_touchdown(state, ground_m)
        column = self._column(state.height)
        velocity = state.velocity[None] + column * state.pitch_rate[None]
        spring = self.stiffness_n_per_m * jnp.maximum(-over, 0.0)
        steep = self.rest_length_m / self.half_span_m
        return Sensation(
            {
                "spring_force": spring,
                "velocity": velocity,
                "height": over + self.rest_length_m,
                "pitch": jnp.broadcast_to(state.pitch, over.shape),
                "pitch_rate": jnp.broadcast_to(state.pitch_rate, over.shape),
            },
            {
                "spring_force": self.mass_kg * self.gravity_m_per_s2,
                "velocity": jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m),
                "height": self.rest_length_m,
                "pitch": steep,
                "pitch_rate": steep * self.rate_scale,
            },
        )

    def _law(self, stance: jax.Array, force_n: jax.Array, rise_n_per_s: jax.Array) -> _Law:
        def in_stance(x) -> jax.Array:
            return jnp.where(stance, x, jnp.zeros_like(force_n))

        return _Law(
            in_stance(force_n),
            in_stance(rise_n_per_s),
            in_stance(self.stiffness_n_per_m),
            in_stance(self.damping_ns_per_m),
        )

    def _motion(self, law: _Law, state: BarState, rest_m: jax.Array) -> _Motion:
        """Heave over touchdown and pitch with their derivatives, as many as `series` needs."""
        column = self._column(state.height)
        mass, inertia = self.total_mass_kg, self.inertia_kg_m2
        heave, pitch = [state.height - rest_m, state.velocity], [state.pitch, state.pitch_rate]
        for n in range(ORDER[state.height.dtype.name] - 1):
            over, faster = (heave[n + i][None] + column * pitch[n + i][None] for i in range(2))
            force = -law.stiffness * over - law.damping * faster
            if n < 2:
                force = force + (law.push, law.rise)[n]
            lift = force.sum(axis=0) / mass
            heave.append(lift - self.gravity_m_per_s2 if n == 0 else lift)
            pitch.append((column * force).sum(axis=0) / inertia)
        return _Motion(heave, pitch)

    def _after(self, motion: _Motion, rest_m: jax.Array, time_s: jax.Array) -> BarState:
        """The state after a time."""
        over, velocity = series(motion.heave, time_s)
        return BarState(rest_m + over, velocity, *series(motion.pitch, time_s))

    def _crossing(self, motion: _Motion, left_s: jax.Array) -> jax.Array:
        """When each hip crosses its touchdown height, if it does [s], [limbs, lanes]."""
        column = self._column(left_s)
        both = zip(motion.heave, motion.pitch, strict=True)
        hips = [y[None] + column * turn[None] for y, turn in both]
        return crossing_time(hips, jnp.broadcast_to(left_s, column.shape))

    def predict(
        self, state: BarState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[BarState, jax.Array, jax.Array]:
        """The state one tick on with the accelerations held, and the stance part of the tick."""
        rest = self.rest_length_m + ground_m
        over = self._over_touchdown(state, ground_m)
        stance = over < 0.0
        law = self._law(stance, force_n, jnp.zeros_like(force_n))
        heave, pitch = self._motion(law, state, rest)
        guess = BarState(
            state.height + tick_s * (heave[1] + 0.5 * tick_s * heave[2]),
            heave[1] + tick_s * heave[2],
            pitch[0] + tick_s * (pitch[1] + 0.5 * tick_s * pitch[2]),
            pitch[1] + tick_s * pitch[2],
        )
        travel = self._over_touchdown(guess, ground_m) - over
        crosses = (over + travel < 0.0) != stance
        crossing = jnp.where(crosses, -over / jnp.where(crosses, travel, 1.0), 1.0)
        crossing = jnp.clip(crossing, 0.0, 1.0)
        return guess, jnp.where(stance, 0.0, crossing), jnp.where(stance, crossing, 1.0)

    def advance(
        self, state: BarState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[BarState, Contact]:
        """The state one tick on under the actuators' pushes, every leg's change of mode located.

        In between all is linear, so the motion is exact up to rounding. Each leg changes its mode
        at most once a tick, the earliest first; the force of one that does is held at its mean.
        """
        rest = jnp.broadcast_to(self.rest_length_m + ground_m, state.height.shape)
        over = self._over_touchdown(state, ground_m)
        stance = over < 0.0
        mean = jnp.broadcast_to(push.mean_n, over.shape)
        slope = jnp.broadcast_to(push.rise_n, over.shape) / tick_s
        law = self._law(stance, mean - 0.5 * slope * tick_s, slope)
        whole = self._after(self._motion(law, state, rest), rest, tick_s)
        crosses = (self._over_touchdown(whole, ground_m) < 0.0) != stance
        zero, none = jnp.zeros_like(state.height), jnp.full_like(state.height, jnp.nan)
        nothing = _Passed(zero, jnp.zeros_like(over), jnp.zeros_like(over), zero, zero, none, none)
        tick_s = jnp.broadcast_to(tick_s, zero.shape)

        def along():
            passed = self._passed(nothing, state, whole, stance, tick_s)
            return whole, passed, jnp.full_like(over, jnp.nan)

        # A leg that changes its mode is held at its mean force, as the hopper's is.
        rising = jnp.where(crosses, 0.0, slope)

        def motion(at: BarState, mode: jax.Array, passed: _Passed) -> _Motion:
            begins = mean + rising * (passed.time - 0.5 * tick_s)[None]
            return self._motion(self._law(mode, begins, rising), at, rest)

        def to_next(_, carry):
            at, mode, switched, passed, touchdown = carry
            left = tick_s - passed.time
            now = motion(at, mode, passed)
            then = self._over_touchdown(self._after(now, rest, left), ground_m)
            will = ((then < 0.0) != mode) & ~switched
            times = jnp.where(will, self._crossing(now, left), jnp.inf)
            step = jnp.where(will.any(axis=0), times.min(axis=0), 0.0)
            ahead = self._after(now, rest, step)
            passed = self._passed(passed, at, ahead, mode, step)
            first = will & (times <= step[None])
            share = passed.time[None] / tick_s[None]
            touchdown = jnp.where(first & ~mode, share, touchdown)
            return ahead, mode ^ first, switched | first, passed, touchdown

        def across():
            begun = (state, stance, jnp.zeros_like(stance), nothing, jnp.full_like(over, jnp.nan))
            reached = jax.lax.fori_loop(0, self.limbs, to_next, begun)
            at, mode, _, passed, touchdown = reached
            left = tick_s - passed.time
            end = self._after(motion(at, mode, passed), rest, left)
            return end, self._passed(passed, at, end, mode, left), touchdown

        end, passed, touchdown = jax.lax.cond(jnp.any(crosses), across, along)
        return end, Contact(
            stance_share=jnp.clip(passed.stance_time / tick_s[None], 0.0, 1.0),
            work_j=mean * passed.stance_travel,
            climb_flight_m=passed.climb_flight,
            climb_m=passed.climb,
            apex_share=jnp.clip(passed.apex_time / tick_s, 0.0, 1.0),
            apex_height_m=passed.apex_height,
            touchdown_share=jnp.clip(touchdown, 0.0, 1.0),
        )

    def _passed(
        self,
        before: _Passed,
        start: BarState,
        end: BarState,
        stance: jax.Array,
        time_s: jax.Array,
    ) -> _Passed:
        """What has happened after a further part of the tick, spent in these modes."""
        column = self._column(start.height)
        travel = (end.height - start.height)[None] + column * (end.pitch - start.pitch)[None]
        climb = rise(start.height, start.velocity, end.height, end.velocity, time_s)
        flies = ~stance.any(axis=0)
        apex = flies & (start.velocity > 0.0) & (end.velocity <= 0.0)
        to_apex = time_s * start.velocity / jnp.where(apex, start.velocity - end.velocity, 1.0)
        height = start.height + 0.5 * start.velocity * to_apex
        return _Passed(
            before.time + time_s,
            before.stance_time + jnp.where(stance, time_s[None], 0.0),
            before.stance_travel + jnp.where(stance, travel, 0.0),
            before.climb_flight + jnp.where(flies, climb, 0.0),
            before.climb + climb,
            jnp.where(apex, before.time + to_apex, before.apex_time),
            jnp.where(apex, height, before.apex_height),
        )

    def failed(self, state: BarState, ground_m: jax.Array) -> jax.Array:
        """True where a leg has no length left."""
        return (self._over_touchdown(state, ground_m) + self.rest_length_m <= 0.0).any(axis=0)

    def height(self, state: BarState) -> jax.Array:
        """Heave y [m]."""
        return state.height

    def velocity(self, state: BarState) -> jax.Array:
        """ẏ [m/s]."""
        return state.velocity

    def energy(self, state: BarState, ground_m: jax.Array) -> jax.Array:
        """½ n m ẏ² + ½ J θ̇² + n m g y + ½ k Σ max(0, -d_i)² [J]."""
        compression = jnp.maximum(-self._over_touchdown(state, ground_m), 0.0)
        mass = self.total_mass_kg
        return (
            0.5 * mass * state.velocity**2
            + 0.5 * self.inertia_kg_m2 * state.pitch_rate**2
            + mass * self.gravity_m_per_s2 * state.height
            + 0.5 * self.stiffness_n_per_m * (compression**2).sum(axis=0)
        )
