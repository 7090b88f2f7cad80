"""Lags: how long after a reference leg each leg steps, in cycles, and whether that lasts.

Leg i steps `lag_i` cycles after the reference leg, `0 <= lag_i < 1`. A lag is a place on a circle:
0.99 and 0.01 are near each other, and their mean is 0. Phases themselves are never averaged, least
of all over lanes, whose rhythms began at different times: only differences within a lane are.

Arrays are [frames, limbs, lanes], of JAX or NumPy.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.simulation.recorder import Trajectory

TURN = 2.0 * math.pi


def apart(a: Numeric, b: Numeric) -> jax.Array:
    """How far lag a is behind lag b, the short way round, in [-0.5, 0.5) [cycles].

    Args:
        a: lags [cycles], any shape.
        b: lags that broadcast against these.

    Example:
        >>> round(float(apart(0.05, 0.95)), 6), round(float(apart(0.5, 0.75)), 6)
        (0.1, -0.25)
    """
    return (jnp.asarray(a) - b + 0.5) % 1.0 - 0.5


def circular_mean(lag: AnyArray, axis: int = 0) -> jax.Array:
    """Mean of lags on the circle, `arg(mean exp(2πi lag)) / 2π`, in [0, 1) [cycles].

    Undefined lags (NaN) do not enter; NaN where there is none.

    Args:
        lag: lags [cycles], any shape.
        axis: the one over which the mean is taken.

    Source:
        Mardia and Jupp, Directional Statistics (2000), section 2.2.

    Example:
        >>> round(float(circular_mean(jnp.array([0.9, 0.2]))), 6)
        0.05
    """
    return _place(_mean_resultant(lag, axis))


def circular_spread(lag: AnyArray, axis: int = 0) -> jax.Array:
    """Circular standard deviation of lags, `√(-2 ln |mean exp(2πi lag)|) / 2π` [cycles].

    Zero for lags that are all alike; infinite for lags that cancel. Undefined lags do not enter.

    Args:
        lag: lags [cycles], any shape.
        axis: the one over which it is taken.

    Source:
        Mardia and Jupp, Directional Statistics (2000), equation 2.3.11.

    Example:
        >>> round(float(circular_spread(jnp.array([0.99, 0.01]))), 4)
        0.01
    """
    length = jnp.minimum(jnp.abs(_mean_resultant(lag, axis)), 1.0)
    return jnp.sqrt(jnp.maximum(-2.0 * jnp.log(length), 0.0)) / TURN


def order_parameter(lag: AnyArray) -> jax.Array:
    """How much in phase the legs of a lane are: `|Σ exp(2πi lag_i)| / n`, 1 if all are.

    Args:
        lag: [limbs, lanes].

    Source:
        Kuramoto, Chemical Oscillations, Waves, and Turbulence (1984).

    Example:
        >>> order_parameter(jnp.array([[0.0, 0.0], [0.0, 0.5]])).round(3).tolist()
        [1.0, 0.0]
    """
    return jnp.abs(_turned(lag).mean(axis=0))


def over_strides(lag: AnyArray, frames_per_stride: AnyArray) -> jax.Array:
    """Running circular mean over the stride that ends at each frame, [frames, limbs, lanes].

    Within a stride lags sway, as legs speed up and slow down at different times; over a whole one
    that averages out. The first strides are averaged over what there is of them.

    Args:
        lag: [frames, limbs, lanes]; undefined ones (NaN) do not enter.
        frames_per_stride: whole numbers, [lanes].
    """
    defined = jnp.isfinite(lag)
    turned = jnp.cumsum(jnp.where(defined, _turned(lag), 0.0), axis=0)
    count = jnp.cumsum(defined.astype("int32"), axis=0)
    frame = jnp.arange(turned.shape[0])[:, None, None]
    begins = frame - jnp.maximum(jnp.asarray(frames_per_stride), 1)[None, None, :]
    begins = jnp.broadcast_to(begins, turned.shape)

    def within(total: jax.Array) -> jax.Array:
        before = jnp.take_along_axis(total, jnp.maximum(begins, 0), axis=0)
        return total - jnp.where(begins >= 0, before, jnp.zeros_like(before))

    return jnp.where(within(count) > 0, _place(within(turned)), jnp.nan)


def time_to_lock(lag: AnyArray, final: AnyArray, time_s: AnyArray, tolerance: float) -> jax.Array:
    """From when on all lags of a lane stay within a tolerance of their final ones [s], [lanes].

    NaN if they never do.

    Args:
        lag: averaged over strides (`over_strides`), [frames, limbs, lanes].
        final: the final lags, [limbs, lanes].
        time_s: of the frames, [frames] or [frames, lanes].
        tolerance: [cycles].

    Example:
        >>> lag = jnp.array([0.0, 0.3, 0.5, 0.49])[:, None, None]
        >>> time_to_lock(lag, jnp.array([[0.5]]), jnp.arange(4.0), 0.05).tolist()
        [2.0]
    """
    near = (jnp.abs(apart(lag, jnp.asarray(final)[None])) <= tolerance).all(axis=1)
    stays = jnp.cumprod(near[::-1].astype("int32"), axis=0)[::-1].astype(bool)
    time = jnp.asarray(time_s)
    time = jnp.broadcast_to(time if time.ndim == 2 else time[:, None], stays.shape)
    first = jnp.argmax(stays, axis=0)
    found = jnp.take_along_axis(time, first[None], axis=0)[0]
    return jnp.where(stays[-1], found, jnp.nan)


def moved(lag: AnyArray) -> jax.Array:
    """How far the lags of a lane have ever been from its first ones [cycles], [lanes].

    Lags that stand still from the release on show no synchronisation: legs that do not feel each
    other, all at one frequency, keep theirs as well.

    Args:
        lag: [frames, limbs, lanes].
    """
    return moved_until(lag)[-1]


def moved_until(lag: AnyArray, allowed: Numeric = 0.0) -> jax.Array:
    """How far the lags have been from the first ones up to every frame [cycles], [frames, lanes].

    Args:
        lag: [frames, limbs, lanes].
        allowed: how far of that says nothing [cycles], a number or [frames, lanes].

    Example:
        >>> lag = jnp.array([0.75, 0.25, 0.5])[:, None, None]
        >>> moved_until(lag).tolist()
        [[0.0], [0.5], [0.5]]
    """
    lag = jnp.asarray(lag)
    first = jnp.argmax(jnp.isfinite(lag), axis=0)
    begun = jnp.take_along_axis(lag, first[None], axis=0)
    far = jnp.abs(apart(lag, begun))
    beyond = jnp.where(jnp.isfinite(far), far, 0.0).max(axis=1) - allowed
    return jax.lax.cummax(jnp.maximum(beyond, 0.0), axis=0)


def rounding(ticks: AnyArray) -> jax.Array:
    """How far two phases part at most as each is rounded every tick [cycles], as `ticks`.

    A phase up to 2π is rounded by half a unit in its last place, 2 ε; two of them by twice that.
    """
    ticks = jnp.asarray(ticks)
    return 4.0 * jnp.finfo(ticks.dtype).eps * ticks / TURN


def drift(omega: AnyArray, time_s: AnyArray, reference: int) -> jax.Array:
    """How far the lags of legs that do not feel each other go, each at its own ω [cycles].

    `(ω_ref - ω_i) t / 2π`, [frames, limbs, lanes].

    Args:
        omega: prescribed frequencies [rad/s], [limbs, lanes].
        time_s: of the frames, [frames, lanes].
        reference: the leg that lags are measured from.
    """
    omega = jnp.asarray(omega)
    return (omega[reference][None] - omega)[None] * time_s[:, None] / TURN


def steps_to_latest(x: AnyArray) -> jax.Array:
    """The latest defined value up to every frame, NaN before the first.

    Example:
        >>> steps_to_latest(jnp.array([jnp.nan, 1.0, jnp.nan, 2.0])).tolist()
        [nan, 1.0, 1.0, 2.0]
    """
    x = jnp.asarray(x)
    frame = jnp.arange(x.shape[0]).reshape(-1, *[1] * (x.ndim - 1))
    at = jax.lax.cummax(jnp.where(jnp.isfinite(x), frame, -1), axis=0)
    return jnp.where(at >= 0, jnp.take_along_axis(x, jnp.maximum(at, 0), axis=0), jnp.nan)


class Rhythm(ABC):
    """Where lags are read from. A frozen dataclass."""

    needs: tuple[str, ...]
    """The channels that it reads."""

    @abstractmethod
    def lag(self, trajectory: Trajectory, reference: int) -> jax.Array:
        """Lag of every leg behind the reference leg, [frames, limbs, lanes] [cycles]."""

    @abstractmethod
    def frequency_hz(self, trajectory: Trajectory, reference: int, first: int) -> jax.Array:
        """Cycles of the reference leg per second, from a frame on, [lanes]."""


@dataclass(frozen=True)
class OfPhases(Rhythm):
    """Lags of the oscillators: `lag_i = (φ_ref - φ_i) / 2π mod 1`.

    Defined at every instant, and unharmed by feet that bounce. The frames must be shorter than half
    a turn.
    """

    needs = ("phase_rad", "time_s")

    def lag(self, trajectory: Trajectory, reference: int) -> jax.Array:
        """Lag of every leg behind the reference leg, [frames, limbs, lanes] [cycles]."""
        phase = jnp.asarray(trajectory.phase_rad)
        return ((phase[:, reference : reference + 1] - phase) / TURN) % 1.0

    def frequency_hz(self, trajectory: Trajectory, reference: int, first: int) -> jax.Array:
        """Turns of the reference leg's oscillator per second, [lanes]."""
        phase = jnp.asarray(trajectory.phase_rad)[first:, reference]
        turns = apart(phase[1:] / TURN, phase[:-1] / TURN).sum(axis=0)
        return turns / (trajectory.time_s[-1] - trajectory.time_s[first])


@dataclass(frozen=True)
class OfTouchdowns(Rhythm):
    """Lags of the footfalls: time since the reference leg's touchdown over its stride.

    For whatever has no oscillators, or to hold beside them. A foot that bounces has several
    touchdowns a stride, and then no lag that means anything.
    """

    needs = ("touchdown_time_s", "time_s")

    def lag(self, trajectory: Trajectory, reference: int) -> jax.Array:
        """Lag of every leg behind the reference leg, [frames, limbs, lanes] [cycles]."""
        touchdowns = jnp.asarray(trajectory.touchdown_time_s)
        latest = steps_to_latest(touchdowns)
        own, earlier = latest[:, reference], jnp.roll(latest[:, reference], 1, axis=0)
        new = jnp.isfinite(touchdowns[:, reference]) & jnp.isfinite(earlier)
        new = new.at[0].set(False)
        stride = steps_to_latest(jnp.where(new, own - earlier, jnp.nan))
        return ((latest - own[:, None]) / stride[:, None]) % 1.0

    def frequency_hz(self, trajectory: Trajectory, reference: int, first: int) -> jax.Array:
        """Touchdowns of the reference leg per second, [lanes]."""
        return step_frequency_hz(trajectory.touchdown_time_s, first)[reference]


def step_frequency_hz(touchdown_time_s: AnyArray, first: int = 0) -> jax.Array:
    """Touchdowns of every leg per second, from its first to its last, [limbs, lanes].

    NaN with fewer than two.

    Args:
        touchdown_time_s: NaN in frames without one [s], [frames, limbs, lanes].
        first: the frame to count from.

    Example:
        >>> times = jnp.array([1.0, jnp.nan, 1.5, 2.0])[:, None, None]
        >>> step_frequency_hz(times).tolist()
        [[2.0]]
    """
    times = jnp.asarray(touchdown_time_s)[first:]
    down = jnp.isfinite(times)
    count = down.sum(axis=0).astype(times.dtype)
    start = jnp.where(down, times, jnp.inf).min(axis=0)
    end = jnp.where(down, times, -jnp.inf).max(axis=0)
    enough = count > 1
    return jnp.where(enough, (count - 1) / jnp.where(enough, end - start, 1.0), jnp.nan)


def _turned(lag: AnyArray) -> jax.Array:
    angle = TURN * jnp.asarray(lag)
    return jax.lax.complex(jnp.cos(angle), jnp.sin(angle))


def _mean_resultant(lag: AnyArray, axis: int) -> jax.Array:
    defined = jnp.isfinite(lag)
    total = jnp.where(defined, _turned(lag), 0.0).sum(axis=axis)
    count = defined.sum(axis=axis).astype(total.dtype)
    return jnp.where(count.real > 0, total / jnp.where(count.real > 0, count, 1.0), jnp.nan)


def _place(resultant: jax.Array) -> jax.Array:
    return (jnp.angle(resultant) / TURN) % 1.0
