"""The contract of a metric."""

from __future__ import annotations

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.episode import HOP_CHANNELS, ClampedEpisodes, Episode
from tegotae.measures.hopping.hopping import Hops, hops
from tegotae.measures.hopping.limit_cycle import LimitCycle, Settled, settled
from tegotae.measures.hopping.metric import (
    PLACES,
    REGIME,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
    Metric,
    derivation_of,
)
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.hopping.registry import find
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Hopper
from tegotae.simulation.checks import probing
from tegotae.simulation.recorder import Trajectory

_FRAME_S = 0.02
_FRAMES = 700


def check_metric(metric: Metric) -> None:
    """Try the contract of `tegotae.measures.hopping.Metric` on a few lanes.

    Checked are: one of the three kinds; name, label, meaning, range and places; a value a lane, of
    the lanes' type, in float32 and float64, within the range or NaN, that depends on no other lane;
    of a `GaitMetric` also that it reads no channel of the recording that it does not declare, of
    a derived one that there are the metrics that it is derived from.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> from tegotae.measures.hopping.registry import find
        >>> check_metric(find("cpgu"))
    """
    name = probing.require_part(metric, Metric)
    if not isinstance(metric, (GaitMetric, ClampedMetric, DerivedMetric)):
        raise TegotaeError(
            f"{name} does not say how it is computed; make a GaitMetric, ClampedMetric or "
            "DerivedMetric"
        )
    _check_words(metric)
    _check_range(metric)
    probing.require_hashable(f"{name} {metric.name}", metric)
    if isinstance(metric, GaitMetric):
        probing.require_names(f"{metric.name}.channels", metric.channels)
        for dtype in probing.DTYPES:
            with jax.enable_x64(dtype == "float64"):
                _check_gait(metric, dtype)
    if isinstance(metric, ClampedMetric):
        _check_clamped(metric)
    if derivation_of(metric) is not None:
        _check_derivation(metric)


def _check_words(metric: Metric) -> None:
    if not (isinstance(metric.name, str) and metric.name.isidentifier()):
        raise TegotaeError(
            f"the metric's name is {metric.name!r}; it becomes the column of a table: use letters, "
            "digits and _, such as peak_force_n"
        )
    for what in ("label", "about"):
        words = getattr(metric, what)
        if not isinstance(words, str) or not words.strip() or not words.isprintable():
            raise TegotaeError(f"{metric.name}.{what} is {words!r}; it must be one line of text")
    if metric.more_is_better not in (True, False, None):
        raise TegotaeError(
            f"{metric.name}.more_is_better is {metric.more_is_better!r}; it must be True, False, "
            "or None where that cannot be said"
        )
    probing.require_names(f"{metric.name}.shown", metric.shown)
    for place in metric.shown:
        if place not in PLACES:
            raise TegotaeError(
                f"{metric.name}.shown names {place!r}; the places are {', '.join(PLACES)}"
            )
    if metric.math:
        from matplotlib.mathtext import MathTextParser  # slow to import

        try:
            MathTextParser("path").parse(metric.math)
        except ValueError as error:
            raise TegotaeError(
                f"{metric.name}.math cannot be drawn: {probing.first_line(error)}"
            ) from None


def _check_range(metric: Metric) -> None:
    try:
        least, most = map(float, metric.range)
    except (TypeError, ValueError):
        raise TegotaeError(
            f"{metric.name}.range is {metric.range!r}; it must be a pair such as (0.0, 1.0)"
        ) from None
    if not least < most:
        raise TegotaeError(
            f"{metric.name}.range is ({least:g}, {most:g}); its first number must be the smaller"
        )


class _DeclaredChannels:
    """A recording of which only what a metric declares may be read."""

    def __init__(self, recorded: Trajectory, metric: GaitMetric) -> None:
        self._recorded, self._metric = recorded, metric

    def __getattr__(self, channel: str) -> AnyArray:
        if channel not in (*HOP_CHANNELS, *self._metric.channels):
            raise TegotaeError(
                f"{self._metric.name} reads the channel {channel!r} but does not declare it; add "
                f"{channel!r} to its channels"
            )
        # What only some bodies or oscillators record is made up.
        found = self._recorded.channels
        return found[channel] if channel in found else 1.0 + 0.1 * found["height_m"]


@cache
def _recordings() -> Trajectory:
    """Recordings of six bodies that bounce, ever lower in some, [frames, lanes]."""
    time_s = np.arange(0.0, (_FRAMES + 2) * _FRAME_S, 0.005)
    lanes = []
    for i in range(probing.LANES):
        omega = 4.0 + 0.7 * i
        # The lane that is spoiled settles; some others die out.
        height = 1.0 + (0.1 + 0.02 * i) * np.exp(-0.2 * (i > 3) * time_s) * np.sin(omega * time_s)
        found = from_samples(
            time_s,
            height,
            rest_length_m=1.0,
            phase_rad=omega * time_s,
            force_n=2.0 + np.cos(omega * time_s),
            frame_s=_FRAME_S,
        )
        whole = {name: x[:_FRAMES] for name, x in found.channels.items()}
        finite = {
            name: x if name in HOP_CHANNELS else np.nan_to_num(x) for name, x in whole.items()
        }
        lanes.append(Trajectory(**finite))
    return jax.tree.map(lambda *each: np.concatenate(each, axis=1), *lanes)


@jax.jit
def _measured(whole: Trajectory) -> tuple[Hops, Settled]:
    """Hops of the recordings, and the limit cycle of their first half: one program for all."""
    table = hops(whole, 1.0)
    return table, settled(table, LimitCycle(), -jnp.inf, whole.time_s[_FRAMES // 2 - 1])


def _check_gait(metric: GaitMetric, dtype: str) -> None:
    what = f"{metric.name}.compute"
    recorded = jax.tree.map(
        lambda x: jnp.asarray(x, None if x.dtype == bool else dtype), _recordings()
    )
    disturbed_at_s = 0.5 * _FRAMES * _FRAME_S

    def compute(whole: Trajectory, table: Hops, cycle: Settled, omega: jax.Array) -> jax.Array:
        window = jax.tree.map(lambda x: x[: _FRAMES // 2], whole)
        episode = Episode(
            trajectory=_DeclaredChannels(window, metric),  # type: ignore[arg-type]
            whole=_DeclaredChannels(whole, metric),  # type: ignore[arg-type]
            hops=table,
            cycle=cycle,
            omega=omega,
            has_oscillator=True,
            rest_length_m=1.0,
            max_force_n=4.0,
            frame_s=_FRAME_S,
            disturbed_at_s=disturbed_at_s,
            limit_cycle=LimitCycle(),
            work="absolute",
        )
        return metric.compute(episode)

    omega = 4.0 + 0.7 * jnp.arange(probing.LANES, dtype=dtype)
    program = jax.jit(compute)
    value = probing.attempt(what, program, recorded, *_measured(recorded), omega)
    _require_value(metric, what, value, dtype)
    spoiled = jax.tree.map(
        lambda x: x if x.dtype == bool else x.at[:, probing.SPOILED].multiply(1.5), recorded
    )
    after = np.asarray(program(spoiled, *_measured(spoiled), omega))
    others = np.arange(probing.LANES) != probing.SPOILED
    if not np.array_equal(np.asarray(value)[others], after[others], equal_nan=True):
        raise TegotaeError(
            f"{what} lets one lane change another; sum, mean and max go over frames (axis=0) only"
        )


def _check_clamped(metric: ClampedMetric) -> None:
    what, phases = f"{metric.name}.compute", 4
    shape = (probing.LANES, phases)
    settles = np.arange(probing.LANES)[:, None] > np.arange(phases)
    period, time_s = np.where(settles, 1.0, np.nan), np.where(settles, 3.0, np.nan)
    whole = np.zeros(shape, "int32")
    failed = np.zeros(shape, bool)
    failed[-1] = True
    episodes = ClampedEpisodes(
        2.0 * np.pi * np.arange(phases) / phases,
        Settled(period, time_s, whole, whole + 3),
        failed,
    )
    try:
        value = np.asarray(metric.compute(episodes), float)
    except Exception as error:
        raise TegotaeError(f"{what} raised {probing.first_line(error)}") from error
    _require_value(metric, what, value, "float64")


def _check_derivation(metric: Metric) -> None:
    derivation = derivation_of(metric)
    assert derivation is not None
    what = f"{metric.name}'s derivation"
    probing.require_names(f"{what}.of", derivation.of)
    values = {}
    for i, name in enumerate(derivation.of):
        low, high = (0.0, 3.0) if name == REGIME else find(name).range
        low, high = max(low, -10.0), min(high, 10.0)
        values[name] = np.random.default_rng(i).uniform(low, high, probing.LANES)
        if name == REGIME:
            values[name] = np.arange(probing.LANES) % 4
    try:
        found = np.asarray(derivation.compute(values, Conditions(Hopper(), drop_m=0.2)), float)
    except Exception as error:
        raise TegotaeError(f"{what} raised {probing.first_line(error)}") from error
    _require_value(metric, what, found, "float64", ranged=False)


def _require_value(
    metric: Metric, what: str, value: AnyArray, dtype: str, *, ranged: bool = True
) -> None:
    if not hasattr(value, "shape"):
        raise TegotaeError(f"{what} returns a {type(value).__name__}; it must return one array")
    probing.require_arrays(what, value, dtype, kind="events")
    found, (least, most) = np.asarray(value), metric.range
    slack = 1e-4
    outside = found[(found < least - slack) | (found > most + slack)]
    if ranged and len(outside):
        raise TegotaeError(
            f"{what} returns {outside[0]:g}, outside of the range ({least:g}, {most:g}) that "
            f"{metric.name} says it has"
        )
