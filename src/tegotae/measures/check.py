"""Check of the contracts that a new part or metric must keep."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, formatted
from tegotae.measures.gaits.metrics import GAIT, WalkMetric, Walks
from tegotae.measures.gaits.names import NO_GAIT
from tegotae.measures.gaits.summary import OF_LEGS, Coordination, coordination_columns
from tegotae.measures.hopping.gait import gait
from tegotae.measures.hopping.hopping import Settled
from tegotae.measures.hopping.metrics import (
    HOP_CHANNELS,
    HOPPING,
    REGIME,
    ClampedEpisodes,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
)
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.metric import PLACES, Metric
from tegotae.measures.robots import RobotEpisode, RobotMetric
from tegotae.parts.bodies import Body, Hopper, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import Oscillator, PhaseOscillator
from tegotae.parts.terms import EllipticFoot, Term
from tegotae.simulation.checks import check_part, probing
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.simulation.summaries import KeptChannels

_FRAME_S = 0.02
_FRAMES = 700
_OMEGA = 4.0 + 0.7 * np.arange(probing.LANES)
_ROUNDING = 1e-4


def check(part: Term | Oscillator | Body | Metric | Controller, body: Body | None = None) -> None:
    """Try the contract of a part on a few lanes.

    A part that passes can go into a `Controller` or a `Rollout`. Each method must give values of
    the shape and type of the lanes, in float32 and float64, that depend on no other lane. Further
    checks are:

    - of a term: a frozen, hashable dataclass; `reads`, `n_weights` and `initial`; that it depends
      on no signal that is missing from `reads`; of a place of the foot, each of its commands; of an
      actuation also `paced` and `full_force`.
    - of an oscillator: a frozen, hashable dataclass; states of one form; a rate for every entry of
      the state; signals that are what `SIGNALS` names; weights of the number that it says. With a
      phase: `start`, `phase` and `sin_cos` that agree; and, over two turns, a phase that is in
      [0, 2π) after `settle` and does not jump within a tick.
    - of a body: a frozen dataclass of numbers that is a pytree; its properties; that `predict`
      agrees with `advance` and the velocity with the height's change, as the tick shrinks; and that
      over 2 s the energy rises by no more than the actuator's work.
    - of a metric: name, label, meaning, range and places; a value a lane, a row or an episode,
      within the range or NaN, that depends on no other; of a `GaitMetric` that it reads no channel
      of the recording that it does not declare; of a derived one that there are the metrics that it
      is derived from.
    - of a controller: each term, the oscillator and the body; that the body senses all that the
      terms read; and that 0.1 s with random weights stays finite in one lane while another lane's
      weights are NaN.

    Args:
        part: a term, an oscillator, a body, a metric or a controller.
        body: body that a controller drives; the paper's hopper by default.

    Raises:
        TegotaeError: for the first breach, in one line with what would be right.

    Example:
        >>> import tegotae
        >>> check(tegotae.Hopper(mass_kg=0.3))
        >>> check(tegotae.recipe("V-reflex-w4").controller(), tegotae.Hopper())
    """
    if body is not None and not isinstance(part, Controller):
        raise TegotaeError("body belongs to the check of a controller; leave it out")
    if isinstance(part, Term | Oscillator | Body | Controller):
        check_part(part, body or Hopper())
    else:  # or of no contract, which is refused
        name = probing.PartTrial.from_part(part, Term, Oscillator, Body, Metric).name
        _check_metric(part, name)


def _check_metric(metric: Metric, name: str) -> None:
    trial_of = next((trial for kind, trial in _TRIALS.items() if isinstance(metric, kind)), None)
    if trial_of is None:
        kinds = ", ".join(kind.__name__ for kind in _TRIALS)
        raise TegotaeError(f"{name} does not say how it is computed; make one of {kinds}")
    for field, (fits, right) in _FIELDS.items():
        value = getattr(metric, field)
        if not _holds(fits, value):
            raise TegotaeError(f"{metric.name}.{field} is {value!r}; it must be {right}")
    probing.PartTrial(f"{name} {metric.name}").hashable(metric)
    for field in {"channels", "of"} & {field.name for field in dataclasses.fields(metric)}:
        probing.PartTrial(metric.name).names(f".{field}", getattr(metric, field))
    trial_of(metric)


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
    """Return recordings of six bodies that bounce, ever lower in some: channels [frames, lanes]."""
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


def _try_gait(metric: GaitMetric) -> None:
    for dtype in probing.DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_gait(metric, dtype)


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

    trial, arguments = _trial(metric), (trajectory, jnp.asarray(_OMEGA, dtype))
    value = trial.attempt(" of the channels that it declares", compute, *arguments)
    _require_value(metric, value, dtype)
    trial.independent("", compute, *arguments)


def _try_clamped(metric: ClampedMetric) -> None:
    _require_value(metric, _attempt(metric, _clamped_episodes()))


def _try_derived(metric: DerivedMetric) -> None:
    values = {source: _values_of(source, seed) for seed, source in enumerate(metric.of)}
    conditions = Conditions(Hopper() if metric.needs_body else None, drop_m=0.2)
    _require_value(metric, _attempt(metric, values, conditions), ranged=False)


def _try_walk(metric: WalkMetric) -> None:
    walks = _walks(metric.channels)
    values, (lanes, starts) = _attempt(metric, walks), walks.stands.shape
    _trial(metric).require(
        values.shape in ((lanes,), (lanes, starts)),
        f" has shape {values.shape}; it must be [rows, starts], {(lanes, starts)}, or [rows]",
    )
    _require_in_range(metric, values)
    others = np.arange(lanes) != probing.SPOILED
    columns = {name: np.asarray(column) for name, column in walks.columns.items()}
    spoiled = {
        name: np.where(np.repeat(others, starts), x, 17.0) if x.dtype.kind == "f" else x
        for name, x in columns.items()
    }
    again = _attempt(metric, dataclasses.replace(walks, columns=spoiled))
    _trial(metric).require(
        np.array_equal(values[others], again[others], equal_nan=True),
        " lets one row change another; reduce over the last axis, the starts, alone",
    )


class _MadeUpWalks(Walks):
    """Releases of any legs: a quantity of legs that are not there is that of the left fore leg."""

    def __getitem__(self, name: str) -> np.ndarray:
        quantity = name.rpartition("_")[0]
        is_there = name in (*self.columns, *self.channels)
        return super().__getitem__(name if is_there else f"{quantity}_LF")


class _MadeUpEpisode(RobotEpisode):
    """An episode of any robot: an entry that is not observed is a force."""

    def __getitem__(self, name: str) -> np.ndarray:
        return super().__getitem__(name if name in self.names else "leg_force")


def _walks(channels: tuple[str, ...]) -> Walks:
    """Return two releases a row of a walker; some fall, and some lock into no gait."""
    legs, starts = ("LF", "RF", "LH", "RH"), 2
    count, draw = probing.LANES * starts, np.random.default_rng(0)
    coordination = {name: draw.uniform(0.1, 0.9, count) for name in Coordination._fields}
    coordination |= {name: draw.uniform(0.1, 0.9, (len(legs), count)) for name in OF_LEGS}
    coordination["fall_time_s"] = np.where(np.arange(count) % 5 == 0, 3.0, np.nan)
    columns = coordination_columns(Coordination(**coordination), legs)
    columns[GAIT] = np.where(np.arange(count) % 3 == 0, NO_GAIT[-1], "trot")
    body, recorded = Walker(), {}
    if channels:
        foot = EllipticFoot(stride_m=0.2, lift_m=0.1, press_m=0.03, shift_rad=0.0)
        controller = Controller(foot, PhaseOscillator(), limbs=len(legs))
        rollout = Rollout(
            controller=controller, timing=Timing(duration_s=5.0), summary=KeptChannels(channels)
        )
        phase = draw.uniform(0.0, 2.0 * np.pi, (len(legs), count))
        weights = np.zeros((count, controller.n_weights))
        path = rollout.run(weights, Scenario(omega=2.0, phase_rad=phase), body)
        recorded = {name: np.asarray(path.channels[name]) for name in channels}
    return _MadeUpWalks(columns, starts, body, recorded)


def _try_robot(metric: RobotMetric) -> None:
    for episode in _robot_episodes():
        values = _attempt(metric, episode)
        one = values.shape in ((), (0,))
        _trial(metric).require(one, f" has shape {values.shape}; it must return one number")
        _require_in_range(metric, values)


def _robot_episodes() -> list[RobotEpisode]:
    """Return an episode of a robot that hops, and one of which nothing further is known."""
    time_s = 0.01 * np.arange(1, 501)
    height_m = 1.0 + 0.2 * np.sin(6.0 * time_s)
    force = np.clip(4.0 * np.sin(6.0 * time_s), -2.0, 2.0)
    observation = np.stack([height_m, force, np.maximum(force, 0.0), 0.1 * time_s], axis=1)
    recorded = {
        "time_s": time_s,
        "observation": observation,
        "names": ("root_height", "leg_force", "foot_force", "root_forward"),
        "action": force[:, None],
        "reward": np.ones(500),
        "phase_rad": 6.0 * time_s[:, None] % (2.0 * np.pi),
        "lasted": 1.0,
        "fitness": 0.5,
        "step_s": 0.01,
    }
    shown = {
        "loads": {"foot_force": observation[:, 2]},
        "force_limits": {"leg_force": (-2.0, 2.0)},
        "work_j": np.cumsum(np.abs(force)) * 0.01,
        "weight_n": 9.81,
        "height_m": height_m,
        "rest_length_m": 1.0,
        "omega": 6.0,
    }
    return [_MadeUpEpisode(**recorded, **shown), _MadeUpEpisode(**recorded)]


def _clamped_episodes() -> ClampedEpisodes:
    """Return episodes of which more settle the higher the lane; the last lane has failed."""
    lanes, phases = probing.LANES, 4
    settles = np.arange(lanes)[:, None] > np.arange(phases)
    period, time_s = np.where(settles, 1.0, np.nan), np.where(settles, 3.0, np.nan)
    hops, failed = np.zeros((lanes, phases), "int32"), np.zeros((lanes, phases), bool)
    failed[-1] = True
    angles = 2.0 * np.pi * np.arange(phases) / phases
    return ClampedEpisodes(angles, Settled(period, time_s, hops, hops + 3), failed)


def _values_of(name: str, seed: int) -> np.ndarray:
    """Return the values that a metric may have, [lanes]."""
    if name == REGIME:
        return np.arange(probing.LANES) % 4
    low, high = np.clip(HOPPING.find(name).range, -10.0, 10.0)
    return np.random.default_rng(seed).uniform(low, high, probing.LANES)


def _trial(metric: Metric, dtype: str = "float64") -> probing.PartTrial:
    return probing.PartTrial(f"{metric.name}.compute", dtype)


def _attempt(metric: Any, *arguments: Any) -> np.ndarray:
    """Return a metric's values; none where it is not defined."""
    try:
        value = metric.compute(*arguments)
        return np.asarray([] if value is None else value, float)
    except Exception as error:
        raise TegotaeError(f"{metric.name}.compute raised {formatted(error)}") from error


def _require_value(
    metric: Metric, value: Any, dtype: str = "float64", *, ranged: bool = True
) -> None:
    trial, is_array = _trial(metric, dtype), hasattr(value, "shape")
    trial.require(is_array, f" returns a {type(value).__name__}; it must return one array")
    trial.arrays("", value, events=True)
    if ranged:
        _require_in_range(metric, np.asarray(value))


def _require_in_range(metric: Metric, values: np.ndarray) -> None:
    lower, upper = metric.range
    outside = values[(values < lower - _ROUNDING) | (values > upper + _ROUNDING)]
    if len(outside):
        raise TegotaeError(
            f"{metric.name}.compute returns {outside[0]:g}, outside of the range ({lower:g}, "
            f"{upper:g}) that {metric.name} says it has"
        )


_TRIALS: dict[type[Metric], Callable[[Any], None]] = {
    GaitMetric: _try_gait,
    ClampedMetric: _try_clamped,
    DerivedMetric: _try_derived,
    WalkMetric: _try_walk,
    RobotMetric: _try_robot,
}
"""Trial of each kind of metric."""
