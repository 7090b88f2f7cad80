"""The contract of a metric."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, formatted
from tegotae.measures.hopping.gait import gait
from tegotae.measures.hopping.hopping import Settled
from tegotae.measures.hopping.metric import (
    HOP_CHANNELS,
    PLACES,
    REGIME,
    ClampedEpisodes,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.hopping.registry import find_metric
from tegotae.parts.bodies import Hopper
from tegotae.simulation.checks import probing
from tegotae.simulation.recorder import Trajectory

_FRAME_S = 0.02
_FRAMES = 700
_OMEGA = 4.0 + 0.7 * np.arange(probing.LANES)
_ROUNDING = 1e-4


def check_metric(metric: Metric) -> None:
    """Try the contract of `tegotae.measures.hopping.Metric` on a few lanes.

    Checked are: one of the three kinds; name, label, meaning, range and places; a value a lane, of
    the lanes' type, in float32 and float64, within the range or NaN, that depends on no other lane;
    of a `GaitMetric` also that it reads no channel of the recording that it does not declare, of
    a derived one that there are the metrics that it is derived from.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> from tegotae.measures.hopping.registry import find_metric
        >>> check_metric(find_metric("cpgu"))
    """
    name = probing.PartTrial.from_part(metric, Metric).name
    if not isinstance(metric, (GaitMetric, ClampedMetric, DerivedMetric)):
        raise TegotaeError(
            f"{name} does not say how it is computed; make a GaitMetric, ClampedMetric or "
            "DerivedMetric"
        )
    for field, (fits, right) in _FIELDS.items():
        value = getattr(metric, field)
        if not _holds(fits, value):
            raise TegotaeError(f"{metric.name}.{field} is {value!r}; it must be {right}")
    probing.PartTrial(f"{name} {metric.name}").hashable(metric)
    trial = probing.PartTrial(metric.name)
    if isinstance(metric, GaitMetric):
        trial.names(".channels", metric.channels)
        for dtype in probing.DTYPES:
            with jax.enable_x64(dtype == "float64"):
                _check_gait(metric, dtype)
    elif isinstance(metric, ClampedMetric):
        _require_value(metric, _attempt(metric, _clamped_episodes()))
    else:
        trial.names(".of", metric.of)
        values = {source: _values_of(source, seed) for seed, source in enumerate(metric.of)}
        conditions = Conditions(Hopper() if metric.needs_body else None, drop_m=0.2)
        _require_value(metric, _attempt(metric, values, conditions), ranged=False)


def _holds(test: Callable[[Any], bool], value: object) -> bool:
    try:
        return test(value)
    except (TypeError, ValueError, AttributeError):  # of another type
        return False


def _is_line(text: object) -> bool:
    return isinstance(text, str) and bool(text.strip()) and text.isprintable()


def _is_drawn(math: str) -> bool:
    """Return whether matplotlib can draw a text; it raises ValueError for one that it cannot."""
    from matplotlib.mathtext import MathTextParser  # slow to import

    return not math or MathTextParser("path").parse(math) is not None


_FIELDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (str.isidentifier, "the name of a table's column, such as peak_force_n"),
    "label": (_is_line, "one line of text"),
    "about": (_is_line, "one line of text"),
    "more_is_better": (lambda x: x in (True, False, None), "True, False, or None for neither"),
    "shown": (lambda x: not isinstance(x, str) and {*x} <= {*PLACES}, f"of {PLACES}"),
    "math": (_is_drawn, "a text that matplotlib can draw"),
    "range": (lambda x: len(x) == 2 and x[0] < x[1], "a pair such as (0.0, 1.0), the least first"),
}
"""Test of each field of a metric, and a description of a valid value."""


@cache
def _recordings() -> dict[str, np.ndarray]:
    """Recordings of six bodies that bounce, ever lower in some: channels [frames, lanes]."""
    time_s = np.arange(0.0, (_FRAMES + 2) * _FRAME_S, 0.005)
    lanes = []
    for i, omega in enumerate(_OMEGA):
        # The lane that is spoiled settles; some others die out.
        height = 1.0 + (0.1 + 0.02 * i) * np.exp(-0.2 * (i > 3) * time_s) * np.sin(omega * time_s)
        columns = {"phase_rad": omega * time_s, "force_n": 2.0 + np.cos(omega * time_s)}
        frames = from_samples(time_s, height, rest_length_m=1.0, frame_s=_FRAME_S, **columns)
        lanes.append(frames.channels)
    joined = {n: np.concatenate([x[n][:_FRAMES] for x in lanes], axis=1) for n in lanes[0]}
    return {n: x if n in HOP_CHANNELS else np.nan_to_num(x) for n, x in joined.items()}


def _check_gait(metric: GaitMetric, dtype: str) -> None:
    recorded = _recordings()
    # What only some bodies or oscillators record is made up; what is not declared is not there.
    channels = dict.fromkeys(metric.channels, 1.0 + 0.1 * recorded["height_m"])
    channels |= {n: x for n, x in recorded.items() if n in (*HOP_CHANNELS, *metric.channels)}
    trajectory = Trajectory(
        **{n: jnp.asarray(x, None if x.dtype == bool else dtype) for n, x in channels.items()}
    )
    half_s = 0.5 * _FRAMES * _FRAME_S

    def compute(trajectory: Trajectory, omega: jax.Array) -> jax.Array:
        of_gait = gait(
            trajectory,
            omega=omega,
            rest_length_m=1.0,
            max_force_n=4.0,
            frame_s=_FRAME_S,
            undisturbed_s=half_s,
            disturbed_at_s=half_s,
            metrics=(metric,),
        )
        return of_gait.values[metric.name]

    trial, arguments = (
        probing.PartTrial(f"{metric.name}.compute"),
        (trajectory, jnp.asarray(_OMEGA, dtype)),
    )
    value = trial.attempt(" of the channels that it declares", compute, *arguments)
    _require_value(metric, value, dtype)
    trial.independent("", compute, *arguments)


def _clamped_episodes() -> ClampedEpisodes:
    """Episodes of which more settle the higher the lane; the last lane has failed."""
    lanes, phases = probing.LANES, 4
    settles = np.arange(lanes)[:, None] > np.arange(phases)
    period, time_s = np.where(settles, 1.0, np.nan), np.where(settles, 3.0, np.nan)
    hops, failed = np.zeros((lanes, phases), "int32"), np.zeros((lanes, phases), bool)
    failed[-1] = True
    angles = 2.0 * np.pi * np.arange(phases) / phases
    return ClampedEpisodes(angles, Settled(period, time_s, hops, hops + 3), failed)


def _values_of(name: str, seed: int) -> np.ndarray:
    """Values that a metric may have, [lanes]."""
    if name == REGIME:
        return np.arange(probing.LANES) % 4
    low, high = np.clip(find_metric(name).range, -10.0, 10.0)
    return np.random.default_rng(seed).uniform(low, high, probing.LANES)


def _attempt(metric: ClampedMetric | DerivedMetric, *arguments: Any) -> np.ndarray:
    try:
        return np.asarray(metric.compute(*arguments), float)
    except Exception as error:
        raise TegotaeError(f"{metric.name}.compute raised {formatted(error)}") from error


def _require_value(
    metric: Metric, value: Any, dtype: str = "float64", *, ranged: bool = True
) -> None:
    trial = probing.PartTrial(f"{metric.name}.compute", dtype)
    scalar = hasattr(value, "shape")
    trial.require(scalar, f" returns a {type(value).__name__}; it must return one array")
    trial.arrays("", value, events=True)
    values, (lower, upper) = np.asarray(value), metric.range
    outside = values[(values < lower - _ROUNDING) | (values > upper + _ROUNDING)]
    if ranged and len(outside):
        raise TegotaeError(
            f"{trial.name} returns {outside[0]:g}, outside of the range ({lower:g}, {upper:g}) "
            f"that {metric.name} says it has"
        )
