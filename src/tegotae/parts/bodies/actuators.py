"""Actuators that are weak and lag behind, in any body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts._shapes import Number, PerLane, StateTree
from tegotae.parts.bodies.base import Contact, Push
from tegotae.parts.bodies.wrapper import BodyWrapper, wide
from tegotae.parts.commands import FORCE
from tegotae.parts.parameters import traceable


class ActuatorsState(NamedTuple):
    """The body's state, and what its actuators have come to."""

    body: StateTree
    """The state of the body."""
    reached: jax.Array
    """What of the command the actuators follow now, [(commands,) (limbs,) lanes]."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Actuators(BodyWrapper):
    """A body whose actuators follow the command u late, and deliver a share of it:

        lag_s · ȧ = u - a,    F_a = strength · a.

    The lag is that of a first-order filter, exact for the mean of the command over a tick. It goes
    on in flight, where no force acts. `a` begins as the first command. With a strength of one and
    no lag nothing changes, to the bit. A foot that is commanded to a place lags alike; it has no
    force of which a share could arrive.

    Args:
        body: the body that they move. Its fields are those of `body.` in a scenario's `changes`.
        strength: share of the force that arrives.
        lag_s: time constant [s].

    Raises:
        TegotaeError: for what is no body, a strength or a lag below zero, or another strength than
            one where feet are commanded to places.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> Actuators(body=Hopper(), strength=0.8, lag_s=0.02).max_force_n
        4.0
    """

    strength: float = 1.0
    lag_s: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite("strength", self.strength, least=0.0)
        require_finite("lag_s", self.lag_s, least=0.0)
        if self.strength != 1.0 and self.COMMANDS != FORCE:
            raise TegotaeError(
                f"strength is {self.strength:g}, and a {type(self.body).__name__} takes places "
                "of its feet, not forces; it must be 1"
            )

    def check_release(self, height_m: float) -> None:
        """As the body within; and a share of the force has to lift it."""
        self.body.check_release(height_m)
        weight_n = getattr(self.body, "weight_n", 0.0)
        if self.COMMANDS == FORCE and self.strength * self.max_force_n <= weight_n:
            raise TegotaeError(
                f"strength is {self.strength:g}: the actuator then pushes with "
                f"{self.strength * self.max_force_n:g} N at most, and the body weighs "
                f"{weight_n:g} N; it cannot hop"
            )

    def release(
        self, height_m: PerLane, velocity_m_per_s: PerLane, **initial_pose: Number
    ) -> ActuatorsState:
        """The state at release; an initial pose is the body's."""
        state = self.body.release(height_m, velocity_m_per_s, **initial_pose)
        commands = () if self.COMMANDS == FORCE else (len(self.COMMANDS),)
        shape = (*commands, *self.limb_shape, *jnp.shape(height_m))
        return ActuatorsState(state, jnp.zeros(shape, height_m.dtype))

    def commanded(self, state: ActuatorsState, command: jax.Array) -> ActuatorsState:
        """As the body's; the actuators are where they are commanded to be."""
        command = jnp.broadcast_to(command, state.reached.shape)
        return ActuatorsState(self.body.commanded(state.body, command), command)

    def _follow(
        self, reached: jax.Array, aim: jax.Array, tick_s: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Mean over a tick, and what is reached at its end, of a command that is held at `aim`."""
        lag = wide(self.lag_s, reached)
        late = jnp.broadcast_to(lag > 0.0, reached.shape)
        rate = tick_s / jnp.where(lag > 0.0, lag, 1.0)
        # Of the way, at the end of the tick; 1 - exp is 0 where a lag is long over the tick.
        gone = -jnp.expm1(-rate)
        far = aim - reached
        mean = reached + far * (1.0 - gone / rate)
        return jnp.where(late, mean, aim), jnp.where(late, reached + far * gone, aim)

    def predict(
        self, state: ActuatorsState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[ActuatorsState, jax.Array, jax.Array]:
        """The body's guess, under what the actuators would deliver."""
        mean, end = self._follow(state.reached, force_n, tick_s)
        arrives = (mean if self.COMMANDS == FORCE else end) * wide(self.strength, mean)
        guess, begins, ends = self.body.predict(state.body, arrives, ground_m, tick_s)
        return ActuatorsState(guess, end), begins, ends

    def advance(
        self, state: ActuatorsState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[ActuatorsState, Contact]:
        """The body one tick on, under what the actuators deliver."""
        mean, end = self._follow(state.reached, push.mean_n, tick_s)
        if self.COMMANDS != FORCE:  # a place, at the tick's end
            moved, contact = self.body.advance(state.body, Push(end, push.rise_n), ground_m, tick_s)
            return ActuatorsState(moved, end), contact
        strength = wide(self.strength, mean)
        late = jnp.broadcast_to(wide(self.lag_s, mean) > 0.0, mean.shape)
        rise = jnp.where(late, end - state.reached, push.rise_n)
        delivered = Push(mean * strength, rise * strength)
        moved, contact = self.body.advance(state.body, delivered, ground_m, tick_s)
        if contact.force_n is None:
            contact = contact._replace(force_n=delivered.mean_n * contact.stance_share)
        return ActuatorsState(moved, end), contact
