"""Lags between legs, footfalls, support, and the section of a gait."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.bodies import Body, Walker
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing

TURN = 2.0 * math.pi


def lag_difference(a: Numeric, b: Numeric) -> jax.Array:
    """Return the circular difference of lag a minus lag b, in [-0.5, 0.5) [cycles].

    Args:
        a: lags [cycles], any shape.
        b: lags that broadcast against these.

    Example:
        >>> round(float(lag_difference(0.05, 0.95)), 6), round(float(lag_difference(0.5, 0.75)), 6)
        (0.1, -0.25)
    """
    return (jnp.asarray(a) - b + 0.5) % 1.0 - 0.5


def circular_mean(lag: AnyArray, axis: int = 0) -> jax.Array:
    """Return the mean of lags on the circle, `arg(mean exp(2πi lag)) / 2π`, in [0, 1) [cycles].

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
    """Return the circular standard deviation of lags, `√(-2 ln |mean exp(2πi lag)|) / 2π` [cycles].

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
    """Return the order parameter of the legs' lags, `|Σ exp(2πi lag_i)| / n`: 1 if all are in
    phase.

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
    """Return the running circular mean over the stride that ends at each frame, [frames, limbs,
    lanes].

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
        begin = jnp.take_along_axis(total, jnp.maximum(begins, 0), axis=0)
        return total - jnp.where(begins >= 0, begin, jnp.zeros_like(begin))

    return jnp.where(within(count) > 0, _place(within(turned)), jnp.nan)


def time_to_lock(lag: AnyArray, final: AnyArray, time_s: AnyArray, tolerance: float) -> jax.Array:
    """Return the time after which all lags of a lane stay within a tolerance of their final values
    [s], [lanes].

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
    near = (jnp.abs(lag_difference(lag, jnp.asarray(final)[None])) <= tolerance).all(axis=1)
    stays = jnp.cumprod(near[::-1].astype("int32"), axis=0)[::-1].astype(bool)
    time = jnp.asarray(time_s)
    time = jnp.broadcast_to(time if time.ndim == 2 else time[:, None], stays.shape)
    first = jnp.argmax(stays, axis=0)
    lock_time = jnp.take_along_axis(time, first[None], axis=0)[0]
    return jnp.where(stays[-1], lock_time, jnp.nan)


def largest_drift(lag: AnyArray) -> jax.Array:
    """Return the largest change of a lane's lags since its first frame [cycles], [lanes].

    Lags that stand still from the release on show no synchronisation: legs that do not feel each
    other, all at one frequency, keep theirs as well.

    Args:
        lag: [frames, limbs, lanes].
    """
    return moved_until(lag)[-1]


def moved_until(lag: AnyArray, allowed: Numeric = 0.0) -> jax.Array:
    """Return the largest change of the lags since the first frame, up to every frame [cycles],
    [frames, lanes].

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
    far = jnp.abs(lag_difference(lag, begun))
    beyond = jnp.where(jnp.isfinite(far), far, 0.0).max(axis=1) - allowed
    return jax.lax.cummax(jnp.maximum(beyond, 0.0), axis=0)


def rounding(ticks: AnyArray) -> jax.Array:
    """Return the largest difference of two phases that rounding in every tick causes [cycles].

    A phase up to 2π is rounded by half a unit in its last place, 2 ε; two of them by twice that.

    Args:
        ticks: how many ticks, any shape; the result has the same.
    """
    ticks = jnp.asarray(ticks)
    return 4.0 * jnp.finfo(ticks.dtype).eps * ticks / TURN


def drift(omega: AnyArray, time_s: AnyArray, reference: int) -> jax.Array:
    """Return the drift of the lags of uncoupled legs, each at its own ω [cycles].

    `(ω_ref - ω_i) t / 2π`, [frames, limbs, lanes].

    Args:
        omega: prescribed frequencies [rad/s], [limbs, lanes].
        time_s: of the frames, [frames, lanes].
        reference: the leg that lags are measured from.
    """
    omega = jnp.asarray(omega)
    return (omega[reference][None] - omega)[None] * time_s[:, None] / TURN


def steps_to_latest(x: AnyArray) -> jax.Array:
    """Return, at every frame, the latest defined value, NaN before the first.

    Example:
        >>> steps_to_latest(jnp.array([jnp.nan, 1.0, jnp.nan, 2.0])).tolist()
        [nan, 1.0, 1.0, 2.0]
    """
    x = jnp.asarray(x)
    frame = jnp.arange(x.shape[0]).reshape(-1, *[1] * (x.ndim - 1))
    index = jax.lax.cummax(jnp.where(jnp.isfinite(x), frame, -1), axis=0)
    return jnp.where(index >= 0, jnp.take_along_axis(x, jnp.maximum(index, 0), axis=0), jnp.nan)


@dataclass(frozen=True)
class OfPhases:
    """Lags of the oscillators: `lag_i = (φ_ref - φ_i) / 2π mod 1`.

    Defined at every instant, and unharmed by feet that bounce. The frames must be shorter than half
    a turn.
    """

    needs = ("phase_rad", "time_s")

    def lag(self, trajectory: Trajectory, reference: int) -> jax.Array:
        """Return the lag of every leg behind the reference leg, [frames, limbs, lanes] [cycles]."""
        phase = jnp.asarray(trajectory.phase_rad)
        return ((phase[:, reference : reference + 1] - phase) / TURN) % 1.0

    def frequency_hz(self, trajectory: Trajectory, reference: int, first: int) -> jax.Array:
        """Return the turns of the reference leg's phase per second, from a frame on, [lanes]."""
        phase = jnp.asarray(trajectory.phase_rad)[first:, reference]
        turns = lag_difference(phase[1:] / TURN, phase[:-1] / TURN).sum(axis=0)
        return turns / (trajectory.time_s[-1] - trajectory.time_s[first])


@dataclass(frozen=True)
class OfTouchdowns:
    """Lags of the footfalls: time since the reference leg's touchdown over its stride.

    For whatever has no oscillators, or to hold beside them. A foot that bounces has several
    touchdowns a stride, and then no lag that means anything.
    """

    needs = ("touchdown_time_s", "time_s")

    def lag(self, trajectory: Trajectory, reference: int) -> jax.Array:
        """Return the lag of every leg behind the reference leg, [frames, limbs, lanes] [cycles]."""
        touchdowns = jnp.asarray(trajectory.touchdown_time_s)
        latest = steps_to_latest(touchdowns)
        reference_time, earlier = latest[:, reference], jnp.roll(latest[:, reference], 1, axis=0)
        new = jnp.isfinite(touchdowns[:, reference]) & jnp.isfinite(earlier)
        new = new.at[0].set(False)
        stride = steps_to_latest(jnp.where(new, reference_time - earlier, jnp.nan))
        return ((latest - reference_time[:, None]) / stride[:, None]) % 1.0

    def frequency_hz(self, trajectory: Trajectory, reference: int, first: int) -> jax.Array:
        """Return the touchdowns of the reference leg per second, from a frame on, [lanes]."""
        return step_frequency_hz(trajectory.touchdown_time_s, first)[reference]


def step_frequency_hz(touchdown_time_s: AnyArray, first: int = 0) -> jax.Array:
    """Return the touchdowns of every leg per second, from its first to its last, [limbs, lanes].

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


_NEWTON_STEPS = 3


@dataclass(frozen=True)
class Sections:
    """A `Rollout`'s summary: lags at the sections after a frame, [cycles, limbs, lanes].

    NaN of sections that the recording does not reach, or after a fall.

    Args:
        first: the frame to begin with.
        cycles: how many sections.
        reference: the leg whose phase makes them.
    """

    first: int
    cycles: int
    reference: int = 0

    needs = ("phase_rad", "failed")

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[jax.Array, jax.Array]:
        """Return the lags, and those at the end, [limbs, lanes]."""
        phase = jnp.asarray(trajectory.phase_rad)
        lag = lags_at_sections(phase[self.first :], self.cycles, self.reference)
        last = (phase[-1, self.reference][None] - phase[-1]) / TURN % 1.0
        fell = trajectory.failed[-1]
        return jnp.where(fell[None, None], jnp.nan, lag), jnp.where(fell[None], jnp.nan, last)


@partial(jax.jit, static_argnums=(1, 2))
def lags_at_sections(phase_rad: AnyArray, cycles: int, reference: int = 0) -> jax.Array:
    """Return the lags whenever the reference leg's phase passes zero, `(φ_ref - φ_i) / 2π` there.

    Between frames phases go along cubics through the four frames around.

    Args:
        phase_rad: [frames, limbs, lanes]; frames shorter than half a turn.
        cycles: how many sections, from the first one on; NaN where the recording ends before.
        reference: the leg.

    Returns:
        [cycles, limbs, lanes] [cycles], in [0, 1).

    Example:
        >>> turns = 0.1 + 0.01 * jnp.arange(300.0)[:, None, None] - jnp.array([[[0.0], [0.25]]])
        >>> lags_at_sections(TURN * turns % TURN, 2)[:, 1, 0].round(3).tolist()
        [0.25, 0.25]
    """
    phase = jnp.asarray(phase_rad) / TURN
    begun = phase[:1] % 1.0
    turns = jnp.concatenate(
        [begun, begun + jnp.cumsum(lag_difference(phase[1:], phase[:-1]), axis=0)]
    )
    reference_turns = turns[:, reference]
    levels = (
        jnp.floor(reference_turns[0])[None]
        + 1.0
        + jnp.arange(cycles, dtype=reference_turns.dtype)[:, None]
    )
    return jax.vmap(lambda level: _lags_at(turns, reference_turns, level))(levels)


def _lags_at(turns: jax.Array, reference: jax.Array, level: jax.Array) -> jax.Array:
    """Return the lags where the reference leg has made so many turns, [limbs, lanes]."""
    past = reference >= level[None]
    next_frame = jnp.argmax(past, axis=0)
    last = len(reference) - 1
    valid = past.any(axis=0) & (next_frame >= 2) & (next_frame < last)
    nearest = jnp.clip(next_frame - 1, 1, last - 2)

    def near(x: jax.Array, offset: int) -> jax.Array:
        index = jnp.broadcast_to(nearest + offset, x.shape[1:])[None]
        return jnp.take_along_axis(x, index, axis=0)[0]

    four = [near(reference, k) - level for k in (-1, 0, 1, 2)]
    share = -four[1] / (four[2] - four[1])
    for _ in range(_NEWTON_STEPS):
        value, slope = jax.jvp(lambda s: _cubic(four, s), (share,), (jnp.ones_like(share),))
        share = share - value / slope
    legs = _cubic([near(turns, k) for k in (-1, 0, 1, 2)], share[None])
    return jnp.where(valid[None], (level[None] - legs) % 1.0, jnp.nan)


def _cubic(four: list[jax.Array], s: jax.Array) -> jax.Array:
    """Return the value at s of the cubic through values at -1, 0, 1 and 2."""
    a, b, c, d = four
    return (
        -a * s * (s - 1.0) * (s - 2.0) / 6.0
        + b * (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0
        - c * (s + 1.0) * s * (s - 2.0) / 2.0
        + d * (s + 1.0) * s * (s - 1.0) / 6.0
    )


class StanceInterval(NamedTuple):
    """A stance of one leg: from touchdown to liftoff [s]."""

    touchdown_s: float
    liftoff_s: float


def stances(time_s: ArrayLike, stance_time_s: ArrayLike) -> tuple[tuple[StanceInterval, ...], ...]:
    """Return the stances of every leg of one lane, from the total of its time in stance.

    Touchdown and liftoff are placed within their frames by how much of these was spent in stance.
    A stance that begins before the recording begins with it, and one that goes on ends with it.

    Args:
        time_s: ends of the frames, [frames].
        stance_time_s: total time in stance up to there [s], [frames, limbs].

    Returns:
        A row of stances a leg.

    Example:
        >>> total = np.array([[0.0], [0.1], [0.2], [0.2]])
        >>> stances(np.array([0.1, 0.2, 0.3, 0.4]), total)
        ((StanceInterval(touchdown_s=0.1, liftoff_s=0.3),),)
    """
    time, total = np.asarray(time_s, float), np.asarray(stance_time_s, float)
    starts = np.concatenate([[2.0 * time[0] - time[1]], time[:-1]])
    gained = np.diff(total, axis=0, prepend=np.zeros((1, total.shape[1])))
    return tuple(_leg_stances(starts, time, gained[:, leg]) for leg in range(total.shape[1]))


_NOTHING = 1e-3
"""Share of a frame below which there was no stance: the rounding of a float32 total."""


def _leg_stances(
    start: np.ndarray, end: np.ndarray, gained: np.ndarray
) -> tuple[StanceInterval, ...]:
    length = end - start
    on = gained > _NOTHING * length
    edges = np.diff(np.concatenate([[False], on, [False]]).astype(int))
    stances = []
    for begin, stop in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        last = stop - 1
        if begin == last:
            touchdown, liftoff = end[begin] - gained[begin], end[begin]
        else:
            touchdown = end[begin] - min(gained[begin], length[begin])
            liftoff = start[last] + min(gained[last], length[last])
        stances.append(StanceInterval(round(float(touchdown), 6), round(float(liftoff), 6)))
    return tuple(stances)


def support_margin_m(body: Walker, lost: tuple[int, ...] = ()) -> float:
    """Return the distance of the mass inside the polygon of the remaining legs' hips [m].

    The least distance from its sides; negative outside. With three legs a negative margin means
    that no standing is possible with feet below their hips, and a positive one that it is.

    Args:
        body: the walker; of its legs those that are `present` count.
        lost: the numbers of legs that are lost besides.

    Raises:
        TegotaeError: for a leg that there is not, or fewer than three that are left.

    Example:
        >>> support_margin_m(Walker()), round(support_margin_m(Walker(), lost=(2,)), 6)
        (0.44, 0.0)
    """
    from scipy.spatial import ConvexHull  # slow to import

    for leg in lost:
        if not 0 <= leg < body.limbs:
            raise TegotaeError(f"leg {leg} is lost; this body has the legs 0 ... {body.limbs - 1}")
    remaining = [k for k in range(body.limbs) if body.present[k] > 0.5 and k not in lost]
    if len(remaining) < 3:
        raise TegotaeError(
            f"{len(remaining)} legs are left; a polygon of support has three or more"
        )
    hips = np.array([body.hips_x_m, body.hips_y_m]).T[remaining]
    sides = ConvexHull(hips).equations  # of each the outward normal, and minus its distance
    return float(-(sides[:, :2] @ [body.com_x_m, body.com_y_m] + sides[:, 2]).max()) + 0.0
