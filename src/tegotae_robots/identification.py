"""The numbers of a one-legged hopper from a recording of its height, load and commands."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
from scipy.ndimage import binary_closing, binary_opening, label
from scipy.signal import savgol_filter
from scipy.stats import t as student

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Hopper
from tegotae.parts.bodies.base import Push
from tegotae.parts.bodies.hopper import HopperState
from tegotae.parts.parameters import changed

FITTED = {
    "mass_kg": "kg",
    "stiffness_n_per_m": "N/m",
    "damping_ns_per_m": "N s/m",
    "rest_length_m": "m",
    "max_force_n": "N",
    "delay_s": "s",
}
"""The fitted numbers and their units: of the hopper, and how late its sensors are."""
SHARE_TO_FIT = 0.8
"""Share of the hops that are fitted; the others check the prediction."""
LEAST_HOPS = 15
AHEAD = (1, 2, 3)
"""Numbers of hops ahead that the check predicts; fewer where there are too few hops."""
_N = len(FITTED)
_STIFF, _LONG, _MOST = 1, 3, 4
"""Rows of stiffness, rest length and largest force."""
_LARGEST_STEP_RAD = 0.05
_LONGEST_START_S = 0.06
_OUT_OF_STEP = 0.1
_OFFSET = 0.02
"""Load in flight, as a share of the mean load, that counts as an offset of the sensor."""
_TIMES_NOISE = 2.0
"""Largest error of a prediction one hop ahead, in noises."""
_DENSEST_KG_PER_M3 = 2000.0
_FLOOR = 1e-5
"""Noise of a smaller share of a signal's deviation is taken to be so much."""


class Log(NamedTuple):
    """A recording at uniform times, arrays [samples]."""

    step_s: float
    height_m: np.ndarray
    load_n: np.ndarray
    """Force of the spring."""
    share: np.ndarray
    """Command, as a share of the actuator's largest force, held until the next sample."""


@dataclass(frozen=True)
class Identified:
    """The fit of a recording.

    Args:
        values: by the names of `FITTED`.
        low: lower ends of the 95 % intervals.
        high: upper ends.
        noise: standard deviation of the noise of height [m] and load [N].
        hops: how many were fitted, and how many were not.
        prediction: a row for each number of hops ahead: errors of height and load in hops that were
            not fitted, over the noise.
    """

    values: dict[str, float]
    low: dict[str, float]
    high: dict[str, float]
    noise: tuple[float, float]
    hops: tuple[int, int]
    prediction: pd.DataFrame


def log_of(samples: pd.DataFrame) -> Log:
    """Return the checked log of a recording.

    Args:
        samples: `time_s`, `height_m`, `spring_force_n` and `command_share`.

    Raises:
        TegotaeError: for uneven times, values that are not finite, or a constant command.
    """
    values = {name: samples[name].to_numpy() for name in samples}
    for name, column in values.items():
        if not np.isfinite(column).all():
            row = int(np.argmin(np.isfinite(column)))
            raise TegotaeError(f"{name} is {column[row]} at sample {row}; fill the gap or cut")
    steps = np.diff(values["time_s"])
    step = float(np.median(steps))
    if not step > 0.0 or np.abs(steps / step - 1.0).max() > _OUT_OF_STEP:
        sample = int(np.argmax(np.abs(steps - step)))
        raise TegotaeError(
            f"the time steps are uneven: {steps[sample]:.4g} s at sample {sample}, and {step:.4g} "
            "s in the median; record at a fixed rate, or set --resample HZ"
        )
    share = values["command_share"]
    if share.min() < -1e-6 or share.max() > 1.0 + 1e-6:
        raise TegotaeError(
            f"the command lies between {share.min():.4g} and {share.max():.4g}; it is a share of "
            "the actuator's largest force, from 0 to 1"
        )
    if np.ptp(share) < 0.05:
        raise TegotaeError(
            f"the command is constant at {share[0]:.4g}; the actuator's limit and the delay need "
            "one that changes by 0.05 at least"
        )
    return Log(step, values["height_m"], values["spring_force_n"], share)


def hop_middles(log: Log) -> tuple[np.ndarray, np.ndarray]:
    """Return the middle sample of every flight, and the number of samples in flight on each side.

    A hop lies between two of the middles.

    Raises:
        TegotaeError: for a recording without stance or flight, or with too few hops.
    """
    noise = float(np.median(np.abs(np.diff(log.load_n)))) / 0.954
    peak = float(np.quantile(log.load_n, 0.95))
    if peak <= 8.0 * noise:
        raise TegotaeError(f"the recording has no stance: the load stays below {peak:.3g} N")
    smooth = np.convolve(log.load_n, np.full(5, 0.2), "same")
    stance = binary_opening(binary_closing(smooth > 0.2 * peak, np.ones(5)), np.ones(5))
    if stance[2:-2].all():
        raise TegotaeError(
            f"the recording has no flight: the load never falls below {0.2 * peak:.3g} N"
        )
    in_flight: Any = np.logical_not(stance)
    runs, count = cast("tuple[np.ndarray, int]", label(in_flight))
    samples = np.arange(len(runs))
    flights = [samples[runs == n] for n in range(2, count)]  # the first and the last may be cut
    middles = np.array([(run[0] + run[-1]) // 2 for run in flights], int)
    if len(middles) <= LEAST_HOPS:
        raise TegotaeError(
            f"the recording is too short: it holds {max(len(middles) - 1, 0)} whole hops, and the "
            f"fit needs {LEAST_HOPS}"
        )
    return middles, np.array([max(len(run) // 2 - 4, 2) for run in flights], int)


def check_flight(log: Log, middles: np.ndarray, sides: np.ndarray) -> None:
    """Raise `TegotaeError` for a load that is not zero in flight: its sensor has an offset.

    Args:
        log: the recording.
        middles: of the flights, samples.
        sides: samples of flight on each side of them.
    """
    in_flight = [log.load_n[m - s : m + s + 1] for m, s in zip(middles, sides, strict=True)]
    for part in np.array_split(np.arange(len(middles)), 5):
        load = np.concatenate([in_flight[flight] for flight in part])
        error = 4.0 * float(load.std()) / np.sqrt(len(load))
        if abs(load.mean()) > _OFFSET * float(log.load_n.mean()) + error:
            at_s = (middles[part[0]] * log.step_s, middles[part[-1]] * log.step_s)
            raise TegotaeError(
                f"the load is {load.mean():.3g} N in flight, from {at_s[0]:.4g} to {at_s[1]:.4g} "
                "s, where it must be 0; take the offset or drift of its sensor off the column"
            )


def start_of(
    log: Log, middles: np.ndarray, begun: np.ndarray, gravity_m_per_s2: float
) -> np.ndarray:
    """Return a first estimate of the fitted numbers, from sums over hops, which average noise.

    The load over the height in stance gives k and l0. From the middle of one flight to that of the
    next, momentum and energy change by

        m (Δẏ + g T) = ∫ F_k + α ∫ u,    m Δ(½ ẏ² + g y) = α ∫ u(t - d) ẏ - c ∫ ẏ²,

    the last integral over stance: the first gives m and α, the second c, for the delay d on a grid
    that leaves the least residual.

    Args:
        log: the recording.
        middles: of the flights, samples.
        begun: height and velocity there [2, flights].
        gravity_m_per_s2: g [m/s²].

    Raises:
        TegotaeError: if mass or force come out negative.
    """
    length = max(7, round(0.08 / log.step_s)) | 1
    load = np.asarray(savgol_filter(log.load_n, length, 3))
    velocity = np.asarray(savgol_filter(log.height_m, length, 3, deriv=1, delta=log.step_s))
    deep = load > 0.3 * np.quantile(load, 0.98)
    height = np.asarray(savgol_filter(log.height_m, length, 3))
    slope, offset = np.polyfit(height[deep], load[deep], 1)
    y, v = begun

    def per_hop(rate: np.ndarray) -> np.ndarray:
        return np.diff(np.concatenate([[0.0], np.cumsum(rate)])[middles]) * log.step_s

    gained = np.diff(v) + gravity_m_per_s2 * np.diff(middles) * log.step_s
    terms = np.stack([gained, -per_hop(log.share)], axis=1)
    (m, alpha), *_ = np.linalg.lstsq(terms, per_hop(log.load_n), rcond=None)
    if slope >= 0.0 or m <= 0.0 or alpha <= 0.0:
        raise TegotaeError(
            "the recording is not that of such a hopper: load, motion and commands give a mass of "
            f"{m:.3g} kg, a stiffness of {-slope:.3g} N/m and a force of {alpha:.3g} N"
        )
    energy = m * np.diff(0.5 * v**2 + gravity_m_per_s2 * y)
    dissipated = per_hop(np.where(load > 0.1 * np.quantile(load, 0.98), velocity**2, 0.0))
    tried = []
    for ticks in range(1 + round(_LONGEST_START_S / log.step_s)):
        late = np.concatenate([np.zeros(ticks), log.share])[: len(load)]
        excess = alpha * per_hop(late * velocity) - energy
        c = max(float(excess @ dissipated / (dissipated @ dissipated)), 0.0)
        tried.append((float(np.square(excess - c * dissipated).sum()), c, ticks * log.step_s))
    _, c, delay = min(tried)
    return np.array([m, -slope, c, -offset / slope, alpha, delay])


def _initial_states(log: Log, middles: np.ndarray, sides: np.ndarray, gravity: float) -> np.ndarray:
    """Return height and velocity in the middles of flights, from their parabolas [2, flights]."""
    states = []
    for middle, side in zip(middles, sides, strict=True):
        time = np.arange(-side, side + 1) * log.step_s
        y = log.height_m[middle - side : middle + side + 1] + 0.5 * gravity * time**2
        states.append((y.mean(), (y @ time) / (time @ time)))
    return np.array(states).T


@partial(jax.jit, static_argnames=("ticks", "parts"))
def _predicted(
    p: jax.Array,
    first: jax.Array,
    pushed: jax.Array,
    step_s: float,
    gravity: float,
    *,
    ticks: int,
    parts: int,
) -> tuple[jax.Array, jax.Array]:
    """Return height and load of segments, [2, ticks, segments], and their derivatives by each
    row of p.
    """

    def predict(p: jax.Array) -> jax.Array:
        body: Hopper = Hopper()
        for name, x in zip([*FITTED][:-1], p, strict=False):
            body = changed(body, name, lambda _, x=x: x)
        body = changed(body, "gravity_m_per_s2", lambda _: gravity)
        tick = step_s / parts
        counted = partial(jnp.arange, dtype=p.dtype)
        moments = first[None].astype(p.dtype) + counted(ticks * parts + 1)[:, None] / parts
        edges = moments * step_s - p[None, _N - 1]
        total = jnp.interp(edges, counted(len(pushed)) * step_s, pushed)
        forces = p[None, _MOST] * jnp.diff(total, axis=0) / tick

        def advance(state: HopperState, force: jax.Array) -> tuple[HopperState, jax.Array]:
            push = Push(force, jnp.zeros_like(force))
            moved, _ = body.advance(state, push, jnp.zeros_like(force), jnp.asarray(tick))
            return moved, state.height

        _, heights = jax.lax.scan(advance, HopperState(p[_N], p[_N + 1]), forces)
        y = heights[::parts]
        load = p[None, _STIFF] * jnp.maximum(p[None, _LONG] - y, 0.0)
        return jnp.stack([y, load])

    basis = jnp.broadcast_to(jnp.eye(len(p), dtype=p.dtype)[:, :, None], (len(p), *p.shape))
    value, derivatives = jax.vmap(
        lambda along: jax.jvp(predict, (p,), (along,)), out_axes=(None, 0)
    )(basis)
    return value, derivatives


class _Segments:
    """Parts of a log, with their simulation."""

    def __init__(self, log: Log, first: np.ndarray, last: np.ndarray, gravity: float) -> None:
        self.log, self.first, self.gravity = log, first, gravity
        self.ticks = int((last - first).max())
        samples = first[:, None] + np.arange(self.ticks)
        self.within = samples < last[:, None]
        samples = np.minimum(samples, len(log.height_m) - 1)
        self.measured = np.stack([log.height_m[samples], log.load_n[samples]], axis=1)
        self.pushed = np.concatenate([[0.0], np.cumsum(log.share) * log.step_s])

    def residuals(
        self, p: np.ndarray, sigma: np.ndarray, parts: int, within: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return residuals over the noise [segments, 2 · ticks], and their derivatives [...,
        rows].
        """
        with jax.enable_x64(True):
            value, slopes = _predicted(
                jnp.asarray(p),
                jnp.asarray(self.first, float),
                jnp.asarray(self.pushed),
                self.log.step_s,
                self.gravity,
                ticks=self.ticks,
                parts=parts,
            )
        mask = (self.within if within is None else within)[:, None, :] / sigma[:, None]
        errors = (self.measured - np.asarray(value).transpose(2, 0, 1)) * mask
        slopes = np.asarray(slopes).transpose(3, 1, 2, 0) * mask[..., None]
        n = len(self.first)
        return errors.reshape(n, -1), slopes.reshape(n, -1, len(p))


def _solved(
    segments: _Segments,
    p: np.ndarray,
    sigma: np.ndarray,
    parts: int,
    within: np.ndarray | None = None,
    *,
    states_only: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit by Levenberg-Marquardt: numbers shared by all segments, and a state of each, projected
    out.

    Returns:
        The solution [rows, segments], the residuals, and the derivatives by the shared numbers
        that the states cannot make up for, [segments, residuals, shared].
    """
    damping = 1e-3
    errors, slopes = segments.residuals(p, sigma, parts, within)
    for _ in range(60):
        q, r = np.linalg.qr(slopes[..., _N:])
        along = np.swapaxes(q, 1, 2)
        projected = errors - (q @ (along @ errors[..., None]))[..., 0]
        shared = slopes[..., :_N] - q @ (along @ slopes[..., :_N])
        step = np.zeros(_N)
        if not states_only:
            matrix = shared.reshape(-1, _N)
            normal = matrix.T @ matrix
            normal += damping * np.diag(np.diag(normal))
            step = np.linalg.solve(normal, matrix.T @ projected.ravel())
        remainder = along @ (errors - slopes[..., :_N] @ step)[..., None]
        states = np.linalg.solve(r, remainder)[..., 0].T
        new = p + np.concatenate([np.repeat(step[:, None], p.shape[1], axis=1), states])
        new[[0, 1, 3, 4]] = np.maximum(new[[0, 1, 3, 4]], 0.2 * p[[0, 1, 3, 4]])
        new_errors, new_slopes = segments.residuals(new, sigma, parts, within)
        cost, new_cost = np.square(errors).sum(), np.square(new_errors).sum()
        if np.isfinite(new_slopes).all() and new_cost <= cost:
            p, errors, slopes, damping = new, new_errors, new_slopes, damping * 0.2
            if cost - new_cost < 1e-8 * cost:
                break
        else:
            damping = max(damping * 10.0, 1e-6)
            if damping > 1e8:
                break
    q, _ = np.linalg.qr(slopes[..., _N:])
    shared = slopes[..., :_N] - q @ (np.swapaxes(q, 1, 2) @ slopes[..., :_N])
    return p, errors, shared


def identify(log: Log, gravity_m_per_s2: float = Hopper.gravity_m_per_s2) -> Identified:
    """Return the fitted numbers of a hopper, with 95 % intervals and a check of the prediction.

    The sensors report height and load of the time t - d; a command acts at once. Every hop is
    simulated from a state of its own, from the middle of one flight to that of the next, and

        Σ ((y_i - ŷ_i) / σ_y)² + ((F_i - F̂_i) / σ_F)²

    is least over all hops (multiple shooting). σ is that of the residuals. The intervals are those
    of the sum over hops of the squared scores, which residuals that are correlated within a hop do
    not make too narrow.

    Args:
        log: from `log_of`.
        gravity_m_per_s2: g [m/s²], which is not fitted.

    Raises:
        TegotaeError: for a recording without stance or flight, with too few hops, or one that no
            hopper explains.
    """
    middles, sides = hop_middles(log)
    check_flight(log, middles, sides)
    begun = _initial_states(log, middles, sides, gravity_m_per_s2)
    theta = start_of(log, middles, begun, gravity_m_per_s2)
    fitted = round(SHARE_TO_FIT * (len(middles) - 1))
    segments = _Segments(log, middles[:fitted], middles[1 : fitted + 1], gravity_m_per_s2)
    p = np.concatenate([np.repeat(theta[:, None], fitted, axis=1), begun[:, :fitted]])
    parts = int(np.ceil(np.sqrt(theta[1] / theta[0]) * log.step_s / _LARGEST_STEP_RAD))
    signals = (log.height_m, log.load_n)
    sigma = np.array(
        [max(np.median(np.abs(np.diff(x))) / 0.954, _FLOOR * x.std()) for x in signals]
    )
    for _ in range(2):
        p, errors, _ = _solved(segments, p, sigma, parts)
        squares = np.square(errors.reshape(fitted, 2, -1)).sum(axis=(0, 2))
        sigma = sigma * np.sqrt(squares / (segments.within.sum() - fitted))
    p, errors, shared = _solved(segments, p, sigma, parts)
    inverse = np.linalg.inv(np.einsum("hri,hrj->ij", shared, shared))
    scores = np.einsum("hri,hr->hi", shared, errors)
    spread = inverse @ (scores.T @ scores) @ inverse * fitted / (fitted - _N)
    half = student.ppf(0.975, fitted - _N) * np.sqrt(np.diag(spread))
    value = p[:_N, 0]
    fit = Identified(
        values=dict(zip(FITTED, value.tolist(), strict=True)),
        low=dict(zip(FITTED, (value - half).tolist(), strict=True)),
        high=dict(zip(FITTED, (value + half).tolist(), strict=True)),
        noise=(float(sigma[0]), float(sigma[1])),
        hops=(fitted, len(middles) - 1 - fitted),
        prediction=_checked(
            log, middles[fitted:], begun[:, fitted:], value, sigma, parts, gravity_m_per_s2
        ),
    )
    check_fit(fit)
    return fit


def check_fit(fit: Identified) -> None:
    """Raise `TegotaeError` for a fit that its own checks contradict.

    It is one with an interval that is not finite or lies below zero, with a mass that no body of
    that length has, or with errors of more than twice the noise in hops that were not fitted.
    """
    causes = (
        "look at the unit and offset of every column, and for a sensor or command that is "
        "recorded late, filtered, or held between samples"
    )
    for name, unit in FITTED.items():
        low, high = fit.low[name], fit.high[name]
        number = re.sub(r"_(kg|n_per_m|ns_per_m|[mns])$", "", name).replace("_", " ")
        if not np.isfinite([low, fit.values[name], high]).all():
            raise TegotaeError(f"the recording does not determine {number}: {causes}")
        if high < 0.0:
            raise TegotaeError(
                f"the fit gives {number} from {low:.3g} to {high:.3g} {unit}, below zero: no "
                f"hopper explains the recording; {causes}"
            )
    mass, length = fit.values["mass_kg"], fit.values["rest_length_m"]
    if mass > _DENSEST_KG_PER_M3 * length**3:
        raise TegotaeError(
            f"the fit gives {mass:.4g} kg to a leg of {length:.3g} m, more than a stone of its "
            "size weighs; look at the units of load and height, such as spring_force=COLUMN[gf]"
        )
    errors = fit.prediction.set_index("hops ahead").loc[1]
    if not (errors <= _TIMES_NOISE).all():
        raise TegotaeError(
            f"the fit predicts hops that were not fitted to {errors.iloc[0]:.2f} times the noise "
            f"of the height and {errors.iloc[1]:.2f} times that of the load, and {_TIMES_NOISE:g} "
            f"are allowed: no hopper explains the recording; {causes}"
        )


def _checked(
    log: Log,
    middles: np.ndarray,
    begun: np.ndarray,
    value: np.ndarray,
    sigma: np.ndarray,
    parts: int,
    gravity: float,
) -> pd.DataFrame:
    """Return the errors of the prediction over the noise, by hops ahead of the one that gives
    the state.
    """
    ahead: Sequence[int] = [n for n in AHEAD if n + 1 < len(middles)]
    length = ahead[-1] + 1
    first = middles[:-length]
    segments = _Segments(log, first, middles[length:], gravity)
    ends = np.stack([middles[n : n + len(first)] for n in range(1, length + 1)])
    samples = first[:, None] + np.arange(segments.ticks)
    p = np.concatenate([np.repeat(value[:, None], len(first), axis=1), begun[:, : len(first)]])
    p, _, _ = _solved(segments, p, sigma, parts, samples < ends[0][:, None], states_only=True)
    rows = []
    for n in ahead:
        within = (samples >= ends[n - 1][:, None]) & (samples < ends[n][:, None])
        errors, _ = segments.residuals(p, sigma, parts, within)
        squares = np.square(errors.reshape(len(first), 2, -1)).sum(axis=(0, 2)) / within.sum()
        rows.append((n, *np.sqrt(squares).tolist()))
    return pd.DataFrame(rows, columns=["hops ahead", "height error / noise", "load error / noise"])
