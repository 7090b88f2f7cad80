"""Hopper legs, upright under a frame that moves in modes: what the bar and the plate share."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, fields
from typing import NamedTuple, cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Number, PerLane
from tegotae.parts.bodies.base import Contact, Push, Sensation, SpringLegs
from tegotae.parts.bodies.frame import (
    FrameModes,
    Law,
    Motion,
    Turn,
    crossing_time,
    in_heave,
    rise,
    series,
)
from tegotae.parts.bodies.hopper import Hopper
from tegotae.parts.channels import Channel, RecordedFrame, State
from tegotae.parts.parameters import numbers


class UprightState(NamedTuple):
    """Position and velocity of the frame: heave first, then its turns; [modes, lanes]."""

    place: jax.Array
    """Heave y [m] and angles [rad]."""
    rate: jax.Array
    """Their rates [m/s], [rad/s]."""


class _Passed(NamedTuple):
    """Events and totals since the beginning of a tick."""

    time: jax.Array
    stance_time: jax.Array
    stance_travel: jax.Array
    touchdown: jax.Array
    climb_flight: jax.Array
    climb: jax.Array
    apex_time: jax.Array
    apex_height: jax.Array

    @classmethod
    def zero(cls, over: jax.Array) -> _Passed:
        """Return the values at the start of a tick, for hips at these heights over touchdown."""
        legs, lanes = jnp.zeros_like(over), jnp.zeros_like(over[0])
        none = jnp.full_like(lanes, jnp.nan)
        return cls(lanes, legs, legs, jnp.full_like(over, jnp.nan), lanes, lanes, none, none)


class _At(NamedTuple):
    """A moment within a tick: heave is over touchdown here."""

    place: jax.Array
    rate: jax.Array
    stance: jax.Array
    changed: jax.Array
    """The legs that have been in both modes, [limbs, lanes]."""
    passed: _Passed


@dataclass(frozen=True, kw_only=True)
class Upright(SpringLegs):
    """The paper's hopper legs, upright under a rigid frame that heaves and turns.

    Hip i is at height `y_i = y + Σ x_i q` over the frame's turns q. In stance, y_i < l0 + h,

        F_i = k (l0 + h - y_i) - c ẏ_i + F_a,i,    0 <= F_a,i <= α,

    in flight F_i = 0; and with m the mass per leg, of n legs,

        n m ÿ = Σ F_i - n m g,    J q̈ = Σ x_i F_i - K q.

    A body is a subclass with fields of its own, that names its `turns`.
    """

    present: tuple[float, ...] | None = numbers(None)
    """1 for each leg that is there, 0 for one that is lost and bears nothing; None if none can
    be lost."""

    @property
    @abstractmethod
    def turns(self) -> tuple[Turn, ...]:
        """The ways in which the frame turns, at least one."""

    @property
    def limbs(self) -> int:
        """Number of legs."""
        return len(self.turns[0].arms_m)

    @property
    def total_mass_kg(self) -> float:
        """n m [kg]."""
        return self.limbs * self.mass_kg

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Every turn's angle and its rate, and where the hips are."""

        def angle(mode: int, name: str) -> tuple[Channel, Channel]:
            return (
                State(
                    f"{name}_rad",
                    f"{name.capitalize()} [rad].",
                    lambda f: f.lane.moment.body.place[mode],
                ),
                State(
                    f"{name}_rate_rad_per_s",
                    f"{name.capitalize()} rate [rad/s].",
                    lambda f: f.lane.moment.body.rate[mode],
                ),
            )

        angles = (angle(mode, turn.name) for mode, turn in enumerate(self.turns, 1))
        turning = tuple(channel for pair in angles for channel in pair)
        return (*turning, State("hip_m", "Height of the hip y_i [m], a limb.", _hips))

    @property
    def fastest_rad_per_s(self) -> float:
        """Bound of the rates of stance [rad/s]."""
        # No rate of all legs on the ground is above that of one whose hip yields the most.
        yields = max(
            1.0 + sum(t.arms_m[leg] ** 2 / (t.inertia_ratio * t.reach_m**2) for t in self.turns)
            for leg in range(self.limbs)
        )
        springs = max(
            t.stiffness_nm_per_rad / (t.inertia_ratio * self.total_mass_kg * t.reach_m**2)
            for t in self.turns
        )
        return max(
            float(yields * self.stiffness_n_per_m / self.mass_kg + springs) ** 0.5,
            yields * self.damping_ns_per_m / self.mass_kg,
        )

    def check_release(self, height_m: float) -> None:
        """Raise `TegotaeError` if, released level and at rest from this height [m], it cannot hop.

        Level, with all legs alike, every leg with its share of the mass is a hopper.
        """
        leg = Hopper(**{field.name: getattr(self, field.name) for field in fields(SpringLegs)})
        try:
            leg.check_release(height_m)
        except TegotaeError as error:
            raise TegotaeError(f"as a leg of this {type(self).__name__.lower()}, {error}") from None

    def _released(
        self, place: tuple[PerLane, *tuple[Number, ...]], rate: tuple[PerLane, *tuple[Number, ...]]
    ) -> UprightState:
        """Return the state with heave and turns at these values."""

        def modes(values: tuple[PerLane, *tuple[Number, ...]]) -> jax.Array:
            return jnp.stack([jnp.zeros_like(values[0]) + x for x in values])

        return UprightState(modes(place), modes(rate))

    def hips(self, state: UprightState) -> jax.Array:
        """Return the heights of the hips y_i [m], [limbs, lanes]."""
        return self._frame(state.place[0]).hips(state.place)

    def _frame(self, like: jax.Array) -> FrameModes:
        return FrameModes.from_turns(self.turns, self.total_mass_kg, self.gravity_m_per_s2, like)

    def _touchdown(self, state: UprightState, ground_m: jax.Array) -> jax.Array:
        """Return the modes of a level frame whose legs just touch the ground, [modes, lanes]."""
        rest_height = jnp.broadcast_to(self.rest_length_m + ground_m, state.place.shape[1:])
        return in_heave(rest_height, len(self.turns))

    def _over_touchdown(self, state: UprightState, ground_m: jax.Array) -> jax.Array:
        """Return the heights of the hips over touchdown d_i [m], [limbs, lanes]."""
        frame = self._frame(state.place[0])
        return frame.hips(state.place - self._touchdown(state, ground_m))

    def _bears(self, over: jax.Array) -> jax.Array:
        """Return a mask of the legs that touch the ground, [limbs, lanes]: those present and
        compressed."""
        pressed = over < 0.0
        if self.present is None:
            return pressed
        present = jnp.stack([jnp.broadcast_to(leg, over.shape[1:]) for leg in self.present])
        return pressed & (present > 0.5)

    def _pressed(self, over: jax.Array) -> jax.Array:
        """Return the compression of the legs [m], [limbs, lanes]."""
        pressed = jnp.maximum(-over, 0.0)
        return pressed if self.present is None else jnp.where(self._bears(over), pressed, 0.0)

    def sense(self, state: UprightState, ground_m: jax.Array) -> Sensation:
        """Return each leg's spring force [N], its hip's velocity [m/s] and height [m], and the
        turns.

        Networks see F_k / (m g), ẏ_i / √(g l0), height / l0, and a turn over the angle at which
        hips at its reach are l0 over the middle.
        """
        over = self._over_touchdown(state, ground_m)
        spring = _per_limb(self.stiffness_n_per_m, over) * self._pressed(over)
        felt: dict[str, tuple[jax.Array, Number]] = {}
        for mode, turn in enumerate(self.turns, 1):
            if turn.name in self.SENSES:
                steep = self.rest_length_m / turn.reach_m
                felt[turn.name] = _per_limb(state.place[mode], over), steep
                rate = _per_limb(state.rate[mode], over)
                felt[f"{turn.name}_rate"] = rate, steep * self.rate_scale
        return Sensation.from_pairs(
            spring_force=(spring, self.mass_kg * self.gravity_m_per_s2),
            velocity=(
                self._frame(state.place[0]).hips(state.rate),
                jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m),
            ),
            height=(over + _per_limb(self.rest_length_m, over), self.rest_length_m),
            **felt,
        )

    def _law(self, stance: jax.Array, force_n: jax.Array, rise_n_per_s: jax.Array) -> Law:
        def in_stance(x: Number) -> jax.Array:
            return jnp.where(stance, _per_limb(x, force_n), jnp.zeros_like(force_n))

        return Law(
            in_stance(force_n),
            in_stance(rise_n_per_s),
            in_stance(self.stiffness_n_per_m),
            in_stance(self.damping_ns_per_m),
        )

    def predict(
        self, state: UprightState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[UprightState, jax.Array, jax.Array]:
        """Return the state one tick on with the accelerations held, and the stance part of the
        tick.
        """
        frame = self._frame(state.place[0])
        place = state.place - self._touchdown(state, ground_m)
        over = frame.hips(place)
        stance = self._bears(over)
        law = self._law(stance, force_n, jnp.zeros_like(force_n))
        acceleration = frame.motion(law, place, state.rate)[2]
        moved = tick_s * (state.rate + 0.5 * tick_s * acceleration)
        guess = UprightState(state.place + moved, state.rate + tick_s * acceleration)
        travel = frame.hips(moved)
        crosses = self._bears(over + travel) != stance
        crossing = jnp.where(crosses, -over / jnp.where(crosses, travel, 1.0), 1.0)
        crossing = jnp.clip(crossing, 0.0, 1.0)
        return guess, jnp.where(stance, 0.0, crossing), jnp.where(stance, crossing, 1.0)

    def advance(
        self, state: UprightState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[UprightState, Contact]:
        """Return the state one tick on under the actuators' pushes, every leg's change of mode
        located.

        In between all is linear, so the motion is exact up to rounding. Each leg changes its mode
        at most once a tick, the earliest first; the force of one that does is held at its mean.
        """
        frame, touchdown = self._frame(state.place[0]), self._touchdown(state, ground_m)
        place, rate = state.place - touchdown, state.rate
        over = frame.hips(place)
        stance = self._bears(over)
        mean = jnp.broadcast_to(push.mean_n, over.shape)
        slope = jnp.broadcast_to(push.rise_n, over.shape) / tick_s
        tick_s = jnp.broadcast_to(tick_s, over.shape[1:])

        def motion(point: _At, slope: jax.Array) -> list[jax.Array]:
            begins = mean + slope * (point.passed.time - 0.5 * tick_s)[None]
            return frame.motion(self._law(point.stance, begins, slope), point.place, point.rate)

        def reached(motion: list[jax.Array], point: _At) -> tuple[jax.Array, jax.Array]:
            return series(motion, (tick_s - point.passed.time)[None])

        def changes(place: jax.Array, point: _At) -> jax.Array:
            return (self._bears(frame.hips(place)) != point.stance) & ~point.changed

        begun = _At(place, rate, stance, jnp.zeros_like(stance), _Passed.zero(over))
        full = motion(begun, slope)
        rising = jnp.where(changes(reached(full, begun)[0], begun), 0.0, slope)

        def ahead(point: _At) -> tuple[_At, list[jax.Array], jax.Array]:
            """A moment, the motion from there, and the legs that will yet change their mode."""
            moved = motion(point, rising)
            return point, moved, changes(reached(moved, point)[0], point)

        def to_next(carry: tuple[_At, list[jax.Array], jax.Array]):
            point, moved, will = carry
            remaining = jnp.broadcast_to(tick_s - point.passed.time, over.shape)
            hips = Motion.linear([frame.hips(x) for x in moved])
            when = jnp.where(will, crossing_time(hips, remaining), jnp.inf)
            step = jnp.where(will.any(axis=0), when.min(axis=0), 0.0)
            first = will & (when <= step[None])
            place, rate = series(moved, step[None])
            passed = self._passed(frame, point, place, rate, step)
            lands = jnp.broadcast_to(passed.time / tick_s, over.shape)
            passed = passed._replace(
                touchdown=jnp.where(first & ~point.stance, lands, passed.touchdown)
            )
            return ahead(_At(place, rate, point.stance ^ first, point.changed | first, passed))

        # A lane without a change takes steps of no time: no lane feels how many others need.
        point, moved, _ = jax.lax.while_loop(lambda carry: carry[2].any(), to_next, ahead(begun))
        place, rate = reached(moved, point)
        passed = self._passed(frame, point, place, rate, tick_s - point.passed.time)
        return UprightState(place + touchdown, rate), Contact(
            stance_share=jnp.clip(passed.stance_time / tick_s[None], 0.0, 1.0),
            work_j=mean * passed.stance_travel,
            climb_flight_m=passed.climb_flight,
            climb_m=passed.climb,
            apex_share=jnp.clip(passed.apex_time / tick_s, 0.0, 1.0),
            apex_height_m=passed.apex_height + touchdown[0],
            touchdown_share=jnp.clip(passed.touchdown, 0.0, 1.0),
        )

    def _passed(
        self, frame: FrameModes, point: _At, place: jax.Array, rate: jax.Array, time_s: jax.Array
    ) -> _Passed:
        """Return the events and totals after a motion of the frame without a change of mode."""
        passed, climbing, climbs = point.passed, point.rate[0], rate[0]
        climb = rise(point.place[0], climbing, place[0], climbs, time_s)
        flies = ~point.stance.any(axis=0)
        apex = flies & (climbing > 0.0) & (climbs <= 0.0)
        to_apex = time_s * climbing / jnp.where(apex, climbing - climbs, 1.0)
        return passed._replace(
            time=passed.time + time_s,
            stance_time=passed.stance_time + jnp.where(point.stance, time_s[None], 0.0),
            stance_travel=passed.stance_travel
            + jnp.where(point.stance, frame.hips(place - point.place), 0.0),
            climb_flight=passed.climb_flight + jnp.where(flies, climb, 0.0),
            climb=passed.climb + climb,
            apex_time=jnp.where(apex, passed.time + to_apex, passed.apex_time),
            apex_height=jnp.where(
                apex, point.place[0] + 0.5 * climbing * to_apex, passed.apex_height
            ),
        )

    def apply_impulse(self, state: UprightState, impulse_ns: jax.Array) -> UprightState:
        """A blow on the middle changes the velocity of the heave by impulse / (n m)."""
        heave = state.rate[0] + impulse_ns / self.total_mass_kg
        return state._replace(rate=state.rate.at[0].set(heave))

    def failed(self, state: UprightState, ground_m: jax.Array) -> jax.Array:
        """Return True where a leg has no length left."""
        over = self._over_touchdown(state, ground_m)
        return (over + _per_limb(self.rest_length_m, over) <= 0.0).any(axis=0)

    def height(self, state: UprightState) -> jax.Array:
        """Return the heave y [m]."""
        return state.place[0]

    def velocity(self, state: UprightState) -> jax.Array:
        """ẏ [m/s]."""
        return state.rate[0]

    def energy(self, state: UprightState, ground_m: jax.Array) -> jax.Array:
        """½ n m ẏ² + ½ Σ J q̇² + n m g y + ½ Σ K q² + ½ k Σ max(0, -d_i)² [J]."""
        frame = self._frame(state.place[0])
        compression = self._pressed(self._over_touchdown(state, ground_m))
        motion = 0.5 * (frame.inertia * state.rate**2 + frame.stiffness * state.place**2)
        return (
            motion.sum(axis=0)
            + self.total_mass_kg * self.gravity_m_per_s2 * state.place[0]
            + 0.5 * self.stiffness_n_per_m * (compression**2).sum(axis=0)
        )


def _hips(frame: RecordedFrame) -> jax.Array:
    body = cast(Upright, frame.body)
    return body.hips(frame.lane.moment.body)


def _per_limb(x: Number, like: jax.Array) -> jax.Array:
    """Return a number, or one per lane, for every limb."""
    return jnp.broadcast_to(jnp.asarray(x, like.dtype), like.shape)
