"""A blow on any body: an impulse at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import require_finite
from tegotae.parts._shapes import Number, PerLane, StateTree
from tegotae.parts.bodies.base import Contact, Push
from tegotae.parts.bodies.wrapper import BodyWrapper
from tegotae.parts.parameters import traceable


class BlowsState(NamedTuple):
    """The body's state, and how many ticks there have been."""

    body: StateTree
    """The state of the body."""
    tick: jax.Array
    """How many ticks there have been, [lanes]."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Blows(BodyWrapper):
    """A body whose centre of mass is struck once, vertically: its velocity changes by impulse / m.

    It is struck at the beginning of the first control tick that does not begin earlier than said.
    An impulse of zero changes nothing, to the bit.

    Args:
        body: the body that is struck. Its fields are those of `body.` in a scenario's `changes`.
        impulse_ns: the impulse, upwards [N s].
        at_s: when [s]; never by default.

    Raises:
        TegotaeError: for what is no body, or an impulse that is no number.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> Blows(body=Hopper(), impulse_ns=-0.1, at_s=5.0).limbs
        1
    """

    impulse_ns: float = 0.0
    at_s: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite("impulse_ns", self.impulse_ns)
        if self.at_s != math.inf:
            require_finite("at_s", self.at_s, least=0.0)

    def release(
        self, height_m: PerLane, velocity_m_per_s: PerLane, **initial_pose: Number
    ) -> BlowsState:
        """The state at release; an initial pose is the body's."""
        state = self.body.release(height_m, velocity_m_per_s, **initial_pose)
        return BlowsState(state, jnp.zeros_like(height_m))

    def commanded(self, state: BlowsState, command: jax.Array) -> BlowsState:
        """As the body's."""
        return state._replace(body=self.body.commanded(state.body, command))

    def _with_impulse(self, state: BlowsState, tick_s: jax.Array) -> BlowsState:
        now = state.tick == jnp.ceil(self.at_s / tick_s - 1e-3)
        impulse = jnp.where(now, self.impulse_ns, 0.0)
        return BlowsState(self.body.apply_impulse(state.body, impulse), state.tick + 1.0)

    def predict(
        self, state: BlowsState, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[BlowsState, jax.Array, jax.Array]:
        """The body's guess, struck or not."""
        return super().predict(self._with_impulse(state, tick_s), force_n, ground_m, tick_s)

    def advance(
        self, state: BlowsState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[BlowsState, Contact]:
        """The body one tick on, struck or not."""
        return super().advance(self._with_impulse(state, tick_s), push, ground_m, tick_s)
