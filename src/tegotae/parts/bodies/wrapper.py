"""A body around another one: it passes on all that it does not do otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts._shapes import Number, StateTree
from tegotae.parts.bodies.base import (
    Body,
    Contact,
    Push,
    Sensation,
    for_limbs,
)
from tegotae.parts.bodies.hopper import Hopper
from tegotae.parts.channels import (
    Channel,
    Latest,
    RecordedFrame,
    State,
    Tick,
    Total,
)

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class BodyWrapper(Body):
    """As the body within; subclasses say what is different.

    Its state is a named tuple that has the state of the body within as `body`. That body's fields
    are those of `body.` in a scenario's `changes`, such as "body.mass_kg".

    Args:
        body: the body within.

    Raises:
        TegotaeError: for what is no body.
    """

    body: Body = field(default_factory=Hopper)

    def __post_init__(self) -> None:
        if not is_of(self.body, Body):
            raise TegotaeError(f"body is {self.body!r}; it must be a Body, such as Hopper()")

    @property
    def SENSES(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        """Those of the body within."""
        return self.body.SENSES

    @property
    def COMMANDS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        """Those of the body within."""
        return self.body.COMMANDS

    @property
    def limbs(self) -> int:
        """Those of the body within."""
        return self.body.limbs

    @property
    def max_force_n(self) -> float:  # type: ignore[override]
        """That of the body within [N]."""
        return self.body.max_force_n

    @property
    def rest_length_m(self) -> float:  # type: ignore[override]
        """That of the body within [m]."""
        return self.body.rest_length_m

    @property
    def touching_height_m(self) -> float:
        """That of the body within [m]."""
        return self.body.touching_height_m

    @property
    def rate_scale(self) -> Number:
        """That of the body within [rad/s]."""
        return self.body.rate_scale

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Those of the body within."""
        return tuple(map(_within, self.body.channels))

    @property
    def pose_names(self) -> tuple[str, ...]:
        """Those of the body within."""
        return self.body.pose_names

    def check_tick(self, tick_s: float) -> None:
        """As the body within."""
        self.body.check_tick(tick_s)

    def check_release(self, height_m: float) -> None:
        """As the body within."""
        self.body.check_release(height_m)

    def sense(self, state: StateTree, ground_m: jax.Array) -> Sensation:
        """As the body within."""
        return self.body.sense(state.body, ground_m)

    def predict(
        self, state: StateTree, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[StateTree, jax.Array, jax.Array]:
        """As the body within."""
        guess, begins, ends = self.body.predict(state.body, force_n, ground_m, tick_s)
        return state._replace(body=guess), begins, ends

    def advance(
        self, state: StateTree, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[StateTree, Contact]:
        """As the body within."""
        end, contact = self.body.advance(state.body, push, ground_m, tick_s)
        return state._replace(body=end), contact

    def apply_impulse(self, state: StateTree, impulse_ns: jax.Array) -> StateTree:
        """As the body within."""
        return state._replace(body=self.body.apply_impulse(state.body, impulse_ns))

    def failed(self, state: StateTree, ground_m: jax.Array) -> jax.Array:
        """As the body within."""
        return self.body.failed(state.body, ground_m)

    def height(self, state: StateTree) -> jax.Array:
        """As the body within [m]."""
        return self.body.height(state.body)

    def velocity(self, state: StateTree) -> jax.Array:
        """As the body within [m/s]."""
        return self.body.velocity(state.body)

    def energy(self, state: StateTree, ground_m: jax.Array) -> jax.Array:
        """As the body within [J]."""
        return self.body.energy(state.body, ground_m)


def wide(of_body: T, like: jax.Array) -> T:
    """A number of the body, with the axes that `like` has before that of the lanes."""
    while 0 < jnp.ndim(cast(jax.Array, of_body)) < like.ndim:
        of_body = for_limbs(of_body)
    return of_body


def _within(channel: Channel) -> Channel:
    """A channel of the body within, of its own state."""

    def inner(body: Body) -> Body:
        return cast(BodyWrapper, body).body

    def unwrapped_frame(frame: RecordedFrame) -> RecordedFrame:
        moment = frame.lane.moment._replace(body=frame.lane.moment.body.body)
        return frame._replace(body=inner(frame.body), lane=frame.lane._replace(moment=moment))

    def unwrapped_tick(tick: Tick) -> Tick:
        end = tick.end._replace(body=tick.end.body.body)
        return tick._replace(body=inner(tick.body), end=end)

    def of_frame(
        value: Callable[[RecordedFrame], jax.Array],
    ) -> Callable[[RecordedFrame], jax.Array]:
        return lambda frame: value(unwrapped_frame(frame))

    def of_tick(value: Callable[[Tick], jax.Array]) -> Callable[[Tick], jax.Array]:
        return lambda tick: value(unwrapped_tick(tick))

    if isinstance(channel, State):
        return replace(channel, of=of_frame(channel.of))
    if isinstance(channel, Total):
        return replace(channel, gain=of_tick(channel.gain))
    if isinstance(channel, Latest):
        return replace(channel, when=of_tick(channel.when), value=of_tick(channel.value))
    return channel
