"""A hopper whose leg stiffens as it is compressed."""

import dataclasses
from dataclasses import dataclass, fields
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae import find
from tegotae.parts import require_finite
from tegotae.parts.bodies import (
    Body,
    Contact,
    Push,
    Sensation,
)
from tegotae.parts.parameters import traceable

_STEPS = 4


class RubberState(NamedTuple):
    """Height y [m] and velocity ẏ [m/s]."""

    height: jax.Array
    velocity: jax.Array


@traceable
@dataclass(frozen=True, kw_only=True)
class RubberHopper(Body):
    """A point mass on a massless leg, `m ÿ = k1 d + k3 d³ - c (d / l0) ẏ + F_a - m g`."""

    SENSES = ("spring_force", "velocity")

    mass_kg: float = 0.1
    stiffness_n_per_m: float = 3.0
    hardening_n_per_m3: float = 20.0
    damping_ns_per_m: float = 0.5
    rest_length_m: float = 1.0
    gravity_m_per_s2: float = 9.81
    max_force_n: float = 4.0

    def __post_init__(self) -> None:
        for field in fields(self):
            require_finite(field.name, getattr(self, field.name), above=0.0)

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l0) [rad/s]: by it a network sees the Tegotae feedback."""
        return jnp.sqrt(self.gravity_m_per_s2 / self.rest_length_m)

    def release(self, height_m: jax.Array, velocity_m_per_s: jax.Array) -> RubberState:
        """The state at release."""
        return RubberState(height_m, velocity_m_per_s)

    def compression(self, height_m: jax.Array, ground_m: jax.Array) -> jax.Array:
        """d [m]."""
        return jnp.maximum(self.rest_length_m + ground_m - height_m, 0.0)

    def spring(self, d: jax.Array) -> jax.Array:
        """F_k [N]."""
        return d * (self.stiffness_n_per_m + self.hardening_n_per_m3 * d * d)

    def sense(self, state: RubberState, ground_m: jax.Array) -> Sensation:
        """F_k and ẏ, and what a network sees them over: the weight, and √(g l0)."""
        force = self.spring(self.compression(state.height, ground_m))
        return Sensation(
            {"spring_force": force, "velocity": state.velocity},
            {
                "spring_force": self.mass_kg * self.gravity_m_per_s2,
                "velocity": jnp.sqrt(self.gravity_m_per_s2 * self.rest_length_m),
            },
        )

    def acceleration(self, y, v, force_n, ground_m) -> jax.Array:
        """ÿ [m/s²]."""
        d = self.compression(y, ground_m)
        leg = self.spring(d) - self.damping_ns_per_m * (d / self.rest_length_m) * v + force_n
        return jnp.where(d > 0.0, leg / self.mass_kg, 0.0) - self.gravity_m_per_s2

    def predict(self, state, force_n, ground_m, tick_s):
        """A cheap guess of the state one tick on, and the part of the tick spent in stance."""
        y, v = state
        a = self.acceleration(y, v, force_n, ground_m)
        guess = RubberState(y + tick_s * (v + 0.5 * tick_s * a), v + tick_s * a)
        stance = y < self.rest_length_m + ground_m
        return guess, jnp.where(stance, 0.0, jnp.ones_like(y)), jnp.ones_like(y)

    def advance(self, state, push: Push, ground_m, tick_s):
        """The state one tick on, by small midpoint steps, and what happened on the way."""
        y, v = state
        dt = tick_s / _STEPS
        zero = jnp.zeros_like(y)
        none = jnp.full_like(y, jnp.nan)
        stance_share, work, climb_flight, climb = zero, zero, zero, zero
        apex_share, apex_height, touchdown_share = none, none, none
        for step in range(_STEPS):
            force = push.mean_n + push.rise_n * ((step + 0.5) / _STEPS - 0.5)
            v_half = v + 0.5 * dt * self.acceleration(y, v, force, ground_m)
            y_half = y + 0.5 * dt * v
            y_next = y + dt * v_half
            v_next = v + dt * self.acceleration(y_half, v_half, force, ground_m)

            stance = y_half < self.rest_length_m + ground_m
            rise = jnp.maximum(y_next - y, 0.0)
            stance_share = stance_share + jnp.where(stance, 1.0 / _STEPS, zero)
            work = work + jnp.where(stance, force * (y_next - y), 0.0)
            climb = climb + rise
            climb_flight = climb_flight + jnp.where(stance, 0.0, rise)
            apex = ~stance & (v > 0.0) & (v_next <= 0.0)
            fraction = v / jnp.where(apex, v - v_next, 1.0)
            apex_share = jnp.where(apex, (step + fraction) / _STEPS, apex_share)
            apex_height = jnp.where(apex, y + 0.5 * dt * v * fraction, apex_height)
            lands = (y >= self.rest_length_m + ground_m) & (y_next < self.rest_length_m + ground_m)
            touchdown_share = jnp.where(lands, (step + 0.5) / _STEPS, touchdown_share)
            y, v = y_next, v_next
        contact = Contact(
            stance_share, work, climb_flight, climb, apex_share, apex_height, touchdown_share
        )
        return RubberState(y, v), contact

    def failed(self, state, ground_m) -> jax.Array:
        """True where the leg has no length left."""
        return state.height - ground_m <= 0.0

    def height(self, state) -> jax.Array:
        """y [m]."""
        return state.height

    def velocity(self, state) -> jax.Array:
        """ẏ [m/s]."""
        return state.velocity

    def energy(self, state, ground_m) -> jax.Array:
        """½ m ẏ² + m g y + ½ k1 d² + ¼ k3 d⁴ [J]."""
        d = self.compression(state.height, ground_m)
        elastic = d * d * (0.5 * self.stiffness_n_per_m + 0.25 * self.hardening_n_per_m3 * d * d)
        kinetic = 0.5 * self.mass_kg * state.velocity**2
        return kinetic + self.mass_kg * self.gravity_m_per_s2 * state.height + elastic


experiment = dataclasses.replace(
    find("AR").experiment(budget=40, body=RubberHopper()), name="AR-on-rubber"
)
"""What `tegotae train rubber_hopper.py:experiment` trains: a model of the paper on this body."""
