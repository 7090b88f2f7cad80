"""Sensors that are late and noisy, before any body."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.transforms import iota
from tegotae.parts._shapes import Number, PerLane, StateTree
from tegotae.parts.bodies.base import Contact, Push, Sensation
from tegotae.parts.bodies.wrapper import BodyWrapper, wide
from tegotae.parts.parameters import STATIC, traceable


class SensorsState(NamedTuple):
    """The body's state, and what its sensors have felt lately."""

    body: StateTree
    """The state of the body."""
    felt: dict[str, jax.Array]
    """The senses at the last ticks, newest first, [ticks, (limbs,) lanes]."""
    measured: dict[str, jax.Array]
    """What of it the sensors report now, [(limbs,) lanes]."""
    tick: jax.Array
    """How many ticks there have been, [lanes]."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Sensors(BodyWrapper):
    """A body that is felt late and with noise: `y(t) = felt(t - delay) + noise · scale · n(t)`.

    n is normal white noise, a number a control tick, sense and limb, the same for lanes of the same
    seed; `scale` is that by which a network sees the sense, such as the weight for a force. Between
    ticks the past is interpolated; before the release, what was felt then was felt always. What is
    felt is what was so at the end of a tick: a ground that drops is felt a tick later under `Hold`.
    Else a delay and a noise of zero change nothing, to the bit.

    Args:
        body: the body behind the sensors. Its fields are those of `body.` in a scenario's
            `changes`, such as "body.mass_kg".
        delay_s: by how much they are late [s].
        noise: standard deviation, as a share of the scale.
        seed: of the noise; lanes of other seeds meet another one.
        most_ticks: the longest delay, in control ticks: how much of the past is kept.

    Raises:
        TegotaeError: for what is no body, a delay or noise below zero, or fewer than one tick.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> leg = Sensors(body=Hopper(), delay_s=0.01, noise=0.05)
        >>> leg.SENSES == Hopper().SENSES
        True
    """

    delay_s: float = 0.0
    noise: float = 0.0
    seed: float = 0.0
    most_ticks: int = field(default=16, metadata=STATIC)

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite("delay_s", self.delay_s, least=0.0)
        require_finite("noise", self.noise, least=0.0)
        require_finite("seed", self.seed)
        require_count("most_ticks", self.most_ticks)

    def check_tick(self, tick_s: float) -> None:
        """Raise `TegotaeError` for a tick too long for the body, or a delay beyond what is kept."""
        self.body.check_tick(tick_s)
        if self.delay_s > self.most_ticks * tick_s * (1.0 + 1e-6):
            raise TegotaeError(
                f"delay_s is {self.delay_s:g}, which is {self.delay_s / tick_s:g} control ticks; "
                f"the sensors keep {self.most_ticks}: give them more most_ticks"
            )

    def release(
        self, height_m: PerLane, velocity_m_per_s: PerLane, **initial_pose: Number
    ) -> SensorsState:
        """The state at release; an initial pose is the body's."""
        state = self.body.release(height_m, velocity_m_per_s, **initial_pose)
        tick = jnp.zeros_like(height_m)
        felt = self.body.sense(state, tick).values
        past = {name: jnp.stack([x] * (self.most_ticks + 1)) for name, x in felt.items()}
        return SensorsState(state, past, felt, tick)

    def commanded(self, state: SensorsState, command: jax.Array) -> SensorsState:
        """As the body's; what is felt then was felt always."""
        placed = self.body.commanded(state.body, command)
        felt = self.body.sense(placed, jnp.zeros_like(state.tick)).values
        past = {name: jnp.stack([x] * (self.most_ticks + 1)) for name, x in felt.items()}
        return SensorsState(placed, past, felt, state.tick)

    def sense(self, state: SensorsState, ground_m: jax.Array) -> Sensation:
        """What the sensors report."""
        scales = self.body.sense(state.body, ground_m).scales
        measured = {
            name: x + self._noise(x, scales[name], state.tick, at)
            for at, (name, x) in enumerate(sorted(state.measured.items()))
        }
        return Sensation(measured, scales)

    def _noise(self, like: jax.Array, scale: Number, tick: jax.Array, sense: int) -> jax.Array:
        seed = jnp.broadcast_to(self.seed, tick.shape).astype(tick.dtype)
        normal = _normal(like, tick, seed, sense)
        return wide(self.noise, like) * wide(scale, like) * normal

    def _felt(
        self, state: SensorsState, body_state: StateTree, ground_m: jax.Array, tick_s: jax.Array
    ) -> SensorsState:
        """The state once the body has come to a state."""
        now = self.body.sense(body_state, ground_m).values
        felt = {name: jnp.concatenate([now[name][None], x[:-1]]) for name, x in state.felt.items()}
        late = self.delay_s / tick_s
        measured = {name: _at(x, wide(late, x[0])) for name, x in felt.items()}
        return SensorsState(body_state, felt, measured, state.tick + 1.0)

    def predict(
        self, state: SensorsState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[SensorsState, jax.Array, jax.Array]:
        """The body's guess, and what the sensors would report of it."""
        guess, begins, ends = self.body.predict(state.body, force_n, ground_m, tick_s)
        return self._felt(state, guess, ground_m, tick_s), begins, ends

    def advance(
        self, state: SensorsState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[SensorsState, Contact]:
        """The body one tick on."""
        end, contact = self.body.advance(state.body, push, ground_m, tick_s)
        return self._felt(state, end, ground_m, tick_s), contact


def _at(past: jax.Array, late: Number) -> jax.Array:
    """The past, newest first, so many ticks ago; linear between them."""
    value = past[0]
    for ago in range(1, len(past)):
        share = jnp.clip(late - (ago - 1), 0.0, 1.0)
        value = value + share * (past[ago] - past[ago - 1])
    return value


def _normal(like: jax.Array, tick: jax.Array, seed: jax.Array, sense: int) -> jax.Array:
    """Normal numbers that follow from tick, seed, sense and limb alone, of the shape of `like`."""
    limb = iota(jnp.uint32, like.shape, 0) if like.ndim > 1 else jnp.uint32(0)
    start = jax.lax.bitcast_convert_type(seed.astype(jnp.float32), jnp.uint32)
    bits = _mixed(start ^ _mixed(tick.astype(jnp.uint32) + jnp.uint32(sense * 0x9E3779B9 % 2**32)))
    bits = _mixed(wide(bits, like) + limb * jnp.uint32(0x85EBCA6B))
    # 23 bits, in the middle of their steps: never 0 or 1.
    uniform = ((bits >> 9).astype(like.dtype) + 0.5) / 2.0**23
    return jax.scipy.special.ndtri(uniform)


def _mixed(bits: jax.Array) -> jax.Array:
    """A hash of 32 bits (C. Wellons, 2018, "lowbias32")."""
    bits = (bits ^ (bits >> 16)) * jnp.uint32(0x7FEB352D)
    bits = (bits ^ (bits >> 15)) * jnp.uint32(0x846CA68B)
    return bits ^ (bits >> 16)
