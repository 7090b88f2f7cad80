"""The one-legged hopper of the paper: a point mass on a massless spring-damper-actuator leg."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.documents import later
from tegotae._support.errors import TegotaeError
from tegotae._support.transforms import cond
from tegotae.parts._shapes import Number
from tegotae.parts.bodies.base import Contact, Push, Sensation, SpringLegs
from tegotae.parts.bodies.frame import (
    ORDER,
    Law,
    Motion,
    crossing_time,
    rise,
)
from tegotae.parts.parameters import not_negative, traceable

_DEPTHS = 256
"""Depths at which a spring's law is tabulated."""
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_QUADRATURE = list(zip((0.5 * (_POINTS + 1.0)).tolist(), (0.5 * _WEIGHTS).tolist(), strict=True))
"""Points in [0, 1] and weights of the integral of a spring's force over its depth."""


class HopperState(NamedTuple):
    """Height y [m] and velocity ẏ [m/s] of the point mass."""

    height: jax.Array
    velocity: jax.Array


@traceable
@dataclass(frozen=True, kw_only=True)
class Hopper(SpringLegs):
    """One-legged hopper, hopping on the spot (paper III-B, equations 8-10).

    Stance iff `y < l0 + h`, with the ground at height h; there

        m ÿ = F_k + F_c + F_a - m g,   F_k = k (l0 + h - y),   F_c = -c ẏ,   0 <= F_a <= α,

    and in flight `ÿ = -g` (all leg forces are zero). The signs of `m g` and `c ẏ` are those of
    mechanics, not those printed in the paper. Defaults: the paper prints no numbers; these are
    the ones of its co-author's public program.

    A leg with dry friction f (`leg_friction_n`) has a further force in stance: -f sign(ẏ), or what
    holds the leg still where this is less. It is constant over a control tick.

    A subclass that overrides `spring` has another law F_k(d) of the depth d = l0 + h - y.

    Raises:
        TegotaeError: for a non-finite value, a mass, stiffness, rest length, gravity or largest
            force that is not positive, or a negative damping.

    Example:
        >>> f"{Hopper(mass_kg=0.2).weight_n:.3f} N"
        '1.962 N'
    """

    SENSES = ("spring_force", "velocity", "height")

    flight_damping_ns_per_m: float = not_negative(0.0)
    """Damping of the body in flight [N s/m]; 0 in the paper."""
    leg_friction_n: float = later(not_negative(0.0))
    """Coulomb friction of the leg f, in stance [N]; 0 in the paper."""

    @property
    def weight_n(self) -> float:
        """Weight m g [N]."""
        return self.mass_kg * self.gravity_m_per_s2

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.is_linear:
            return
        _, force_n = self._tabulated
        if force_n[0] != 0.0 or not (np.isfinite(force_n).all() and (np.diff(force_n) > 0.0).all()):
            raise TegotaeError(
                f"{type(self).__name__}.spring gives {force_n[0]:g} ... {force_n[-1]:g} N for a "
                f"depth of 0 ... {self.rest_length_m:g} m; the force must begin at 0 and increase"
            )

    def spring(self, depth: Any) -> Any:
        """Return the spring force F_k [N] of a leg that is pressed by `depth` >= 0 [m].

        A subclass may override it, with operators and functions of `jax.numpy`. The force must be 0
        at a depth of 0, and increase.

        Args:
            depth: compression of the leg [m], a number or an array.
        """
        return self.stiffness_n_per_m * depth

    @property
    def is_linear(self) -> bool:
        """True if the spring is that of equation 9, F_k = k d."""
        return type(self).spring is Hopper.spring

    @property
    def _tabulated(self) -> tuple[np.ndarray, np.ndarray]:
        """Depths from 0 to l0 [m], and the spring's force there [N]."""
        depth_m = np.linspace(0.0, self.rest_length_m, _DEPTHS)
        return depth_m, np.asarray(self.spring(depth_m), float)

    @property
    def most_spring_n(self) -> float:
        """Spring force of a leg that is pressed to no length [N]."""
        return float(self.spring(self.rest_length_m))

    def depth(self, spring_n: Any) -> Any:
        """Return the depth [m] at which the spring has a force.

        Args:
            spring_n: force of the spring [N], a number or an array.
        """
        if self.is_linear:
            return spring_n / self.stiffness_n_per_m
        depth_m = self.rest_length_m * jnp.linspace(0.0, 1.0, _DEPTHS)
        return jnp.interp(jnp.asarray(spring_n), self.spring(depth_m), depth_m)

    @property
    def natural_frequency_rad_per_s(self) -> float:
        """Undamped natural frequency of stance √(k/m) [rad/s]; of a spring that is not linear, k is
        the steepest slope."""
        if self.is_linear:
            return float(self.stiffness_n_per_m / self.mass_kg) ** 0.5
        depth_m, force_n = self._tabulated
        return float((np.diff(force_n) / np.diff(depth_m)).max() / self.mass_kg) ** 0.5

    @property
    def fastest_rad_per_s(self) -> float:
        """The faster of the rates of stance and of its damping [rad/s]."""
        return max(self.natural_frequency_rad_per_s, self.damping_ns_per_m / self.mass_kg)

    def check_release(self, height_m: float) -> None:
        """Raise `TegotaeError` if, released at rest from this height [m], it can never hop.

        It cannot if the actuator does not lift the weight, if the release is below the leg's
        length, from where nothing falls, or if the first landing presses the leg to nothing even
        where the actuator pushes with all its force.
        """
        if self.max_force_n <= self.weight_n:
            raise TegotaeError(
                f"this hopper cannot hop: its actuator pushes with {self.max_force_n:g} N at most, "
                f"and it weighs {self.weight_n:g} N"
            )
        if height_m < self.rest_length_m:
            raise TegotaeError(
                f"released from {height_m:g} m this hopper does not fall onto its leg, which is "
                f"{self.rest_length_m:g} m long; release it from there or higher"
            )
        if self._landing_depth_m(height_m) >= self.rest_length_m:
            raise TegotaeError(
                f"released from {height_m:g} m this hopper breaks its leg: even at full push the "
                f"landing presses it to nothing, and it is {self.rest_length_m:g} m long"
            )

    def _landing_depth_m(self, height_m: float) -> float:
        """Return the largest compression of the leg at full push in the first landing after a
        release at rest [m]: m ẏ² / 2 has gone into spring, damper and actuator there; l0 where it
        does not."""
        depth_m, force_n = self._tabulated
        between_n = 0.5 * (force_n[1:] + force_n[:-1])
        step_m = float(depth_m[1])
        square = 2.0 * self.gravity_m_per_s2 * (height_m - self.rest_length_m)
        for begin_m, spring_n in zip(depth_m[:-1].tolist(), between_n.tolist(), strict=True):
            previous, current = square, square
            for _ in range(2):  # Heun's method
                mean = 0.5 * (math.sqrt(previous) + math.sqrt(max(current, 0.0)))
                leg_n = self.max_force_n + spring_n + self.damping_ns_per_m * mean
                current = previous + 2.0 * step_m * (self.gravity_m_per_s2 - leg_n / self.mass_kg)
            if current <= 0.0:
                return begin_m + step_m * previous / (previous - current)
            square = current
        return self.rest_length_m

    def release(self, height_m: jax.Array, velocity_m_per_s: jax.Array) -> HopperState:
        """Return the state at release: height [m] and velocity [m/s]."""
        return HopperState(height_m, velocity_m_per_s)

    def sense(self, state: HopperState, ground_m: jax.Array) -> Sensation:
        """Return the spring force F_k (equation 9) [N], velocity ẏ [m/s] and height above ground
        [m].

        Networks see F_k / (m g), ẏ / √(g l0) and (y - h) / l0.
        """
        clearance = state.height - ground_m
        spring = self.spring(jnp.maximum(self.rest_length_m - clearance, 0.0))
        speed = jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m)
        return Sensation.from_pairs(
            spring_force=(spring, self.weight_n),
            velocity=(state.velocity, speed),
            height=(clearance, self.rest_length_m),
        )

    def _law(self, stance: jax.Array, force_n: jax.Array, rise_n_per_s: jax.Array | float) -> Law:
        """Return the law of stance (equation 8) or of flight, lane by lane, all per mass."""
        inverse_mass = 1.0 / self.mass_kg
        return Law(
            jnp.where(stance, force_n * inverse_mass, 0.0) - self.gravity_m_per_s2,
            jnp.where(stance, rise_n_per_s * inverse_mass, 0.0),
            jnp.where(stance, self.stiffness_n_per_m * inverse_mass, 0.0),
            jnp.where(stance, self.damping_ns_per_m, self.flight_damping_ns_per_m) * inverse_mass,
        )

    def _acceleration(
        self, law: Law, stance: jax.Array, x: jax.Array, v: jax.Array, time_s: Number = 0.0
    ) -> jax.Array:
        """ẍ a time after the start [m/s²]."""
        push = law.push + law.rise * time_s
        if self.is_linear:
            return push - law.stiffness * x - law.damping * v
        spring = jnp.where(stance, self.spring(jnp.maximum(-x, 0.0)), 0.0) / self.mass_kg
        return push + spring - law.damping * v

    def _friction(
        self, law: Law, stance: jax.Array, x: jax.Array, v: jax.Array, tick_s: jax.Array
    ) -> jax.Array:
        """Return the acceleration by the leg's dry friction, held over a tick [m/s²]: it brings the
        leg to rest if it can."""
        most = jnp.where(stance, self.leg_friction_n / self.mass_kg, 0.0)
        acceleration = self._acceleration(law, stance, x, v)
        return jnp.clip(-(v / tick_s + acceleration), -most, most)

    def _motion(self, law: Law, stance: jax.Array, x: jax.Array, v: jax.Array) -> Motion:
        """Return the motion in stance or in flight, lane by lane."""
        if self.is_linear:
            return Motion.linear(_derivatives(law, x, v))
        return Motion.integrated(partial(self._acceleration, law, stance), x, v)

    def predict(
        self, state: HopperState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[HopperState, jax.Array, jax.Array]:
        """Return the state one tick on with the acceleration held, and the stance part of the
        tick.
        """
        x0, v0 = state.height - (self.rest_length_m + ground_m), state.velocity
        stance = x0 < 0.0
        law = self._law(stance, force_n, 0.0)
        acceleration = self._acceleration(law, stance, x0, v0)
        acceleration = acceleration + self._friction(law, stance, x0, v0, tick_s)
        travel = tick_s * (v0 + 0.5 * tick_s * acceleration)
        crosses = (x0 + travel < 0.0) != stance
        crossing = jnp.where(crosses, -x0 / jnp.where(crosses, travel, 1.0), 1.0)
        guess = HopperState(state.height + travel, v0 + tick_s * acceleration)
        return guess, jnp.where(stance, 0.0, crossing), jnp.where(stance, crossing, 1.0)

    def advance(
        self, state: HopperState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[HopperState, Contact]:
        """Return the state one tick on under the actuator's push, with touchdown or lift-off
        located.

        Where the spring is linear, both modes are, so the motion is exact up to rounding; that of
        another spring is integrated (`Motion`). A change of mode is located inside the tick, and
        the rest of the tick is spent in the other mode, under the mean force. At most one change a
        tick: a contact or a flight shorter than a tick ends with it.
        """
        rest_height = self.rest_length_m + ground_m
        x0, v0 = state.height - rest_height, state.velocity
        stance = x0 < 0.0
        held = self._law(stance, push.mean_n, 0.0)
        rising = self._law(stance, push.mean_n - 0.5 * push.rise_n, push.rise_n / tick_s)
        friction = self._friction(held, stance, x0, v0, tick_s)
        held, rising = (law._replace(push=law.push + friction) for law in (held, rising))
        x_whole, v_whole = self._motion(rising, stance, x0, v0).after(tick_s)
        crosses = (x_whole < 0.0) != stance

        def across() -> tuple[jax.Array, jax.Array, jax.Array, jax.Array]:
            motion = self._motion(held, stance, x0, v0)
            crossing = jnp.where(crosses, crossing_time(motion, tick_s), tick_s)
            _, v_cross = motion.after(crossing)
            second, at_rest_length = self._law(~stance, push.mean_n, 0.0), jnp.zeros_like(x0)
            friction = self._friction(second, ~stance, at_rest_length, v_cross, tick_s)
            second = second._replace(push=second.push + friction)
            beyond = self._motion(second, ~stance, at_rest_length, v_cross)
            x1, v1 = beyond.after(tick_s - crossing)
            pick = partial(jnp.where, crosses)
            return crossing, pick(v_cross, v_whole), pick(x1, x_whole), pick(v1, v_whole)

        def along() -> tuple[jax.Array, jax.Array, jax.Array, jax.Array]:
            return jnp.broadcast_to(tick_s, x0.shape), v_whole, x_whole, v_whole

        # Few ticks see any lane change its mode: a quarter of the work is for those alone.
        first_s, v_mid, x1, v1 = cond(jnp.any(crosses), across, along)
        x_mid = jnp.where(crosses, 0.0, x_whole)
        second_s = tick_s - first_s
        rise_before = rise(x0, v0, x_mid, v_mid, first_s)
        rise_after = rise(x_mid, v_mid, x1, v1, second_s)
        # The flight part of the tick, from a to b.
        flies = crosses | ~stance
        xa, va = jnp.where(stance, x_mid, x0), jnp.where(stance, v_mid, v0)
        vb = jnp.where(stance, v1, v_mid)
        apex = flies & (va > 0.0) & (vb <= 0.0)
        to_apex = jnp.where(stance, second_s, first_s) * va / jnp.where(apex, va - vb, 1.0)
        apex_s = jnp.where(stance, first_s, 0.0) + to_apex
        return HopperState(rest_height + x1, v1), Contact(
            stance_share=jnp.where(stance, first_s, second_s) / tick_s,
            work_j=push.mean_n * jnp.where(stance, x_mid - x0, x1 - x_mid),
            climb_flight_m=jnp.where(stance, rise_after, rise_before),
            climb_m=rise_before + rise_after,
            apex_share=jnp.where(apex, apex_s / tick_s, jnp.nan),
            apex_height_m=jnp.where(apex, rest_height + xa + 0.5 * va * to_apex, jnp.nan),
            touchdown_share=jnp.where(crosses & ~stance, first_s / tick_s, jnp.nan),
        )

    def apply_impulse(self, state: HopperState, impulse_ns: jax.Array) -> HopperState:
        """A blow changes the velocity by impulse / m."""
        return state._replace(velocity=state.velocity + impulse_ns / self.mass_kg)

    def failed(self, state: HopperState, ground_m: jax.Array) -> jax.Array:
        """Return True where the leg has no length left, `y <= h`."""
        return state.height - ground_m <= 0.0

    def height(self, state: HopperState) -> jax.Array:
        return state.height

    def velocity(self, state: HopperState) -> jax.Array:
        return state.velocity

    def energy(self, state: HopperState, ground_m: jax.Array) -> jax.Array:
        """½ m ẏ² + m g y + ∫ F_k dd [J], the last ½ k max(0, l0 + h - y)² of a linear spring."""
        compression = jnp.maximum(self.rest_length_m + ground_m - state.height, 0.0)
        if self.is_linear:
            elastic = 0.5 * self.stiffness_n_per_m * compression**2
        else:
            forces = (weight * self.spring(point * compression) for point, weight in _QUADRATURE)
            elastic = compression * sum(forces)
        return 0.5 * self.mass_kg * state.velocity**2 + self.weight_n * state.height + elastic


def _derivatives(law: Law, x: jax.Array, v: jax.Array) -> list[jax.Array]:
    """x and its derivatives under a linear law, as many as `series` needs.

    From the fourth on, each follows from the two before it:
    x⁽ⁿ⁺²⁾ = -stiffness·x⁽ⁿ⁾ - damping·x⁽ⁿ⁺¹⁾.
    """
    derivatives = [x, v, law.push - law.stiffness * x - law.damping * v]
    derivatives.append(law.rise - law.stiffness * v - law.damping * derivatives[2])
    for _ in range(ORDER[x.dtype.name] - 3):
        derivatives.append(-law.stiffness * derivatives[-2] - law.damping * derivatives[-1])
    return derivatives
