"""Bodies around another one: lagged actuators, late or noisy sensors, blows and pushes."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.transforms import iota
from tegotae.parts._shapes import Number, PerLane, Scalar, StateTree
from tegotae.parts.bodies.base import Body, Contact, Push, Sensation, for_limbs
from tegotae.parts.bodies.hopper import Hopper
from tegotae.parts.channels import FORCE, Channel, Combined, RecordedFrame, State, Tick
from tegotae.parts.parameters import a_part, finite, not_negative, traceable, whole, within

T = TypeVar("T")


def _of_state(method: str) -> Any:
    """Forward a method of a wrapper to the body within, with that body's state."""

    def call(self: BodyWrapper, state: StateTree, *ground_m: PerLane) -> Any:
        """Delegate to the wrapped body."""
        return getattr(self.body, method)(state.body, *ground_m)

    return call


@dataclass(frozen=True, kw_only=True)
class BodyWrapper(Body):
    """A body that delegates to another; subclasses override the differences.

    Its state is a named tuple that has the state of the body within as `body`. That body's fields
    are those of `body.` in a scenario's `changes`, such as "body.mass_kg".

    Args:
        body: the body within.

    Raises:
        TegotaeError: for what is no body.
    """

    INSIDE: ClassVar[tuple[str, ...]] = ("body",)

    body: Body = a_part(Body, "a Body, such as Hopper()", Hopper)

    SENSES = within("body")
    COMMANDS = within("body")
    limbs = within("body")  # type: ignore[override]
    max_force_n = within("body")
    weight_n = within("body")
    rest_length_m = within("body")
    touching_height_m = within("body")  # type: ignore[override]
    rate_scale = within("body")  # type: ignore[override]
    pose_names = within("body")  # type: ignore[override]
    check_tick = within("body")
    check_release = within("body")
    sense = _of_state("sense")
    failed = _of_state("failed")
    height = _of_state("height")
    velocity = _of_state("velocity")
    energy = _of_state("energy")

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of the body within."""
        return tuple(map(_within, self.body.channels))

    def release(
        self, height_m: PerLane, velocity_m_per_s: PerLane, **initial_pose: Number
    ) -> StateTree:
        """Return the state at release; an initial pose is the body's."""
        state = self.body.release(height_m, velocity_m_per_s, **initial_pose)
        return self.released(state, jnp.zeros_like(height_m))

    @abstractmethod
    def released(self, state: StateTree, zero: PerLane) -> StateTree:
        """Return the state at release, from that of the body within and a zero in every lane."""

    def before(self, state: StateTree, tick_s: Scalar) -> StateTree:
        """Return the state after the effects on the body at the beginning of a tick."""
        return state

    def after(
        self, state: StateTree, body: StateTree, ground_m: PerLane, tick_s: Scalar
    ) -> StateTree:
        """Return the state at the end of a tick, with the body within in the state `body`."""
        return state._replace(body=body)

    def predict(
        self, state: StateTree, force_n: jax.Array, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[StateTree, jax.Array, jax.Array]:
        """Delegate to the wrapped body, with the hooks of the wrapper."""
        state = self.before(state, tick_s)
        guess, begins, ends = self.body.predict(state.body, force_n, ground_m, tick_s)
        return self.after(state, guess, ground_m, tick_s), begins, ends

    def advance(
        self, state: StateTree, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[StateTree, Contact]:
        """Delegate to the wrapped body, with the hooks of the wrapper."""
        state = self.before(state, tick_s)
        end, contact = self.body.advance(state.body, push, ground_m, tick_s)
        return self.after(state, end, ground_m, tick_s), contact

    def apply_impulse(self, state: StateTree, impulse_ns: jax.Array) -> StateTree:
        """Delegate to the wrapped body."""
        return state._replace(body=self.body.apply_impulse(state.body, impulse_ns))

    def commanded(self, state: StateTree, command: jax.Array) -> StateTree:
        """Delegate to the wrapped body."""
        return state._replace(body=self.body.commanded(state.body, command))


def wide(of_body: T, like: jax.Array) -> T:
    """A number of the body, with the axes that `like` has before that of the lanes."""
    while 0 < jnp.ndim(cast(jax.Array, of_body)) < like.ndim:
        of_body = for_limbs(of_body)
    return of_body


def _within(channel: Channel) -> Channel:
    """A channel of the body within, of its own state."""

    def of_inner(function: Callable[..., Any]) -> Callable[[Any], jax.Array]:
        def of_frame(frame: RecordedFrame) -> jax.Array:
            moment = frame.lane.moment._replace(body=frame.lane.moment.body.body)
            body = cast(BodyWrapper, frame.body).body
            return function(frame._replace(body=body, lane=frame.lane._replace(moment=moment)))

        def of_tick(tick: Tick) -> jax.Array:
            end = tick.end._replace(body=tick.end.body.body)
            return function(tick._replace(body=cast(BodyWrapper, tick.body).body, end=end))

        return of_frame if isinstance(channel, State) else of_tick

    values: dict[str, Any] = {field.name: getattr(channel, field.name) for field in fields(channel)}
    functions = {name: of_inner(value) for name, value in values.items() if callable(value)}
    return channel if isinstance(channel, Combined) else replace(channel, **functions)


class ActuatorsState(NamedTuple):
    """The body's state, and the present outputs of its actuators."""

    body: StateTree
    """The state of the body."""
    reached: jax.Array
    """Filtered command that the actuators follow, [(commands,) (limbs,) lanes]."""


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

    strength: float = not_negative(1.0)
    lag_s: float = not_negative(0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.strength != 1.0 and self.COMMANDS != FORCE:
            raise TegotaeError(
                f"strength is {self.strength:g}, and a {type(self.body).__name__} takes places "
                "of its feet, not forces; it must be 1"
            )

    def check_release(self, height_m: float) -> None:
        """Check the wrapped body's release; the scaled force must lift the body, too."""
        self.body.check_release(height_m)
        weight_n = getattr(self.body, "weight_n", 0.0)
        if self.COMMANDS == FORCE and self.strength * self.max_force_n <= weight_n:
            raise TegotaeError(
                f"strength is {self.strength:g}: the actuator then pushes with "
                f"{self.strength * self.max_force_n:g} N at most, and the body weighs "
                f"{weight_n:g} N; it cannot hop"
            )

    def released(self, state: StateTree, zero: PerLane) -> ActuatorsState:
        """Return the state at release, when nothing is reached yet."""
        commands = () if self.COMMANDS == FORCE else (len(self.COMMANDS),)
        shape = (*commands, *self.limb_shape, *jnp.shape(zero))
        return ActuatorsState(state, jnp.zeros(shape, zero.dtype))

    def commanded(self, state: ActuatorsState, command: jax.Array) -> ActuatorsState:
        """Delegate to the wrapped body; the actuators start at the command."""
        command = jnp.broadcast_to(command, state.reached.shape)
        return ActuatorsState(self.body.commanded(state.body, command), command)

    def _follow(
        self, reached: jax.Array, aim: jax.Array, tick_s: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Return the mean over a tick, and the value at its end, under a command that is held
        at `aim`.
        """
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
        """Predict the body's state under the output of the actuators."""
        mean, end = self._follow(state.reached, force_n, tick_s)
        arrives = (mean if self.COMMANDS == FORCE else end) * wide(self.strength, mean)
        guess, begins, ends = self.body.predict(state.body, arrives, ground_m, tick_s)
        return ActuatorsState(guess, end), begins, ends

    def advance(
        self, state: ActuatorsState, push: Push, ground_m: jax.Array, tick_s: jax.Array
    ) -> tuple[ActuatorsState, Contact]:
        """Advance the body by a tick under the output of the actuators."""
        mean, end = self._follow(state.reached, push.mean_n, tick_s)
        delivered = Push(end, push.rise_n)  # a place, at the tick's end
        if self.COMMANDS == FORCE:
            strength = wide(self.strength, mean)
            late = jnp.broadcast_to(wide(self.lag_s, mean) > 0.0, mean.shape)
            rise = jnp.where(late, end - state.reached, push.rise_n)
            delivered = Push(mean * strength, rise * strength)
        moved, contact = self.body.advance(state.body, delivered, ground_m, tick_s)
        if self.COMMANDS == FORCE and contact.force_n is None:
            contact = contact._replace(force_n=delivered.mean_n * contact.stance_share)
        return ActuatorsState(moved, end), contact


class SensorsState(NamedTuple):
    """The body's state, and the recent readings of its sensors."""

    body: StateTree
    """The state of the body."""
    felt: dict[str, jax.Array]
    """The senses at the last ticks, newest first, [ticks, (limbs,) lanes]."""
    measured: dict[str, jax.Array]
    """Readings that the sensors report, by quantity, [(limbs,) lanes]."""
    tick: jax.Array
    """Number of ticks since the release, [lanes]."""


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

    delay_s: float = not_negative(0.0)
    noise: float = not_negative(0.0)
    seed: float = finite(0.0)
    most_ticks: int = whole(16, static=True)

    def check_tick(self, tick_s: float) -> None:
        """Raise `TegotaeError` for a tick too long for the body, or a delay longer than the
        kept history.
        """
        self.body.check_tick(tick_s)
        if self.delay_s > self.most_ticks * tick_s * (1.0 + 1e-6):
            raise TegotaeError(
                f"delay_s is {self.delay_s:g}, which is {self.delay_s / tick_s:g} control ticks; "
                f"the sensors keep {self.most_ticks}: give them more most_ticks"
            )

    def released(self, state: StateTree, zero: PerLane) -> SensorsState:
        """Fill the sensors' history with the reading at the release."""
        felt = self.body.sense(state, zero).values
        past = {name: jnp.stack([x] * (self.most_ticks + 1)) for name, x in felt.items()}
        return SensorsState(state, past, felt, zero)

    def commanded(self, state: SensorsState, command: jax.Array) -> SensorsState:
        """Delegate to the wrapped body; fill the sensors' history with the reading then."""
        return self.released(self.body.commanded(state.body, command), jnp.zeros_like(state.tick))

    def sense(self, state: SensorsState, ground_m: jax.Array) -> Sensation:
        """Return the sensors' reports."""
        scales = self.body.sense(state.body, ground_m).scales
        measured = {
            name: x + self._noise(x, scales[name], state.tick, index)
            for index, (name, x) in enumerate(sorted(state.measured.items()))
        }
        return Sensation(measured, scales)

    def _noise(self, like: jax.Array, scale: Number, tick: jax.Array, sense: int) -> jax.Array:
        seed = jnp.broadcast_to(self.seed, tick.shape).astype(tick.dtype)
        normal = _normal(like, tick, seed, sense)
        return wide(self.noise, like) * wide(scale, like) * normal

    def after(
        self, state: SensorsState, body: StateTree, ground_m: PerLane, tick_s: Scalar
    ) -> SensorsState:
        """Return the body's state and the sensors' reports of it."""
        readings = self.body.sense(body, ground_m).values
        felt = {
            name: jnp.concatenate([readings[name][None], x[:-1]]) for name, x in state.felt.items()
        }
        late = self.delay_s / tick_s
        measured = {name: _delayed(x, wide(late, x[0])) for name, x in felt.items()}
        return SensorsState(body, felt, measured, state.tick + 1.0)


def _delayed(past: jax.Array, late: Number) -> jax.Array:
    """Return the value so many ticks ago, from the past, newest first; linear between them."""
    value = past[0]
    for ago in range(1, len(past)):
        share = jnp.clip(late - (ago - 1), 0.0, 1.0)
        value = value + share * (past[ago] - past[ago - 1])
    return value


def _normal(like: jax.Array, tick: jax.Array, seed: jax.Array, sense: int) -> jax.Array:
    """Return normal numbers that depend on tick, seed, sense and limb alone, of the shape of
    `like`.
    """
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


class BlowsState(NamedTuple):
    """The body's state, and how many ticks there have been."""

    body: StateTree
    """The state of the body."""
    tick: jax.Array
    """Number of ticks since the release, [lanes]."""


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

    impulse_ns: float = finite(0.0)
    at_s: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.at_s != math.inf:
            require_finite("at_s", self.at_s, least=0.0)

    def released(self, state: StateTree, zero: PerLane) -> BlowsState:
        """Return the state at release, before any tick."""
        return BlowsState(state, zero)

    def before(self, state: BlowsState, tick_s: Scalar) -> BlowsState:
        """Strike the body if the blow is due."""
        strikes = state.tick == jnp.ceil(self.at_s / tick_s - 1e-3)
        impulse = jnp.where(strikes, self.impulse_ns, 0.0)
        return BlowsState(self.body.apply_impulse(state.body, impulse), state.tick + 1.0)


class PushesState(NamedTuple):
    """The body's state."""

    body: StateTree
    """The state of the body."""


@traceable
@dataclass(frozen=True, kw_only=True)
class Pushes(BodyWrapper):
    """A body whose centre of mass is pushed vertically by an outer force, such as a wind.

    Half of a tick's impulse acts at its beginning and half at its end, so that the error is of
    second order in the tick. A force of zero changes nothing, to the bit.

    Args:
        body: the body that is pushed. Its fields are those of `body.` in a scenario's `changes`.
        push_z_n: the force, upwards [N].

    Raises:
        TegotaeError: for what is no body, or a force that is no number.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> Pushes(body=Hopper(), push_z_n=0.1).limbs
        1
    """

    push_z_n: float = finite(0.0)

    def released(self, state: StateTree, zero: PerLane) -> PushesState:
        """Return the body's state alone."""
        return PushesState(state)

    def before(self, state: PushesState, tick_s: Scalar) -> PushesState:
        """Apply half of the impulse to the body."""
        return PushesState(self._pushed(state.body, tick_s))

    def after(
        self, state: PushesState, body: StateTree, ground_m: PerLane, tick_s: Scalar
    ) -> PushesState:
        """Apply the other half of the impulse to the body."""
        return PushesState(self._pushed(body, tick_s))

    def _pushed(self, body: StateTree, tick_s: Scalar) -> StateTree:
        impulse = jnp.broadcast_to(
            jnp.asarray(0.5 * self.push_z_n * tick_s), jnp.shape(self.body.velocity(body))
        )
        return self.body.apply_impulse(body, impulse)
