"""Contract of a metric, and its sources: a recorded gait, its hops and limit cycle."""

from __future__ import annotations

import importlib
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, Self, SupportsIndex

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.hopping import (
    Hops,
    LimitCycle,
    Settled,
    at_frame,
    dies_out,
    find_limit_cycle,
    hops,
)
from tegotae.measures.hopping.signals import Spectrum, peak, spectrum, work_total
from tegotae.measures.hopping.statistics import UNBOUNDED, Range
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.rollout import Trajectory

FAILED, AT_REST, UNSETTLED, LIMIT_CYCLE = range(4)
REGIMES = ("failed", "at rest", "no limit cycle", "limit cycle")
"""Regimes of a gait; `Episode.regime` is an index into it."""

HOP_CHANNELS = (
    *("time_s", "ground_m", "failed", "touchdown_time_s"),
    *("apex_time_s", "apex_height_m", "apex_phase_rad"),
)
"""The channels from which hops and limit cycle follow; every metric may read them."""


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One episode of every lane, as it was recorded. Arrays end in lanes.

    All but what comes after a disturbance is measured in the undisturbed window, from the release
    on, and there on the settled part: from the first settled apex to the window's end.

    Args:
        trajectory: the undisturbed window's frames, [frames, lanes] each.
        whole: all frames, those after the disturbance among them.
        omega: prescribed frequency ω [rad/s], one or [lanes]; NaN if it is not known.
        rest_length_m: rest length of the leg l0 [m].
        max_force_n: largest actuator force α [N].
        frame_s: recording period [s].
        disturbed_at_s: time of the disturbance [s], one or [lanes]; None if there is none, infinite
            in lanes without.
        limit_cycle: what counts as settled.
        work: definition of work, one of "absolute", "positive", "net".
        has_oscillator: False where no frequency is prescribed at all; ΔΩ is then zero.
    """

    trajectory: Trajectory
    whole: Trajectory
    omega: Numeric
    rest_length_m: Numeric
    max_force_n: Numeric
    frame_s: float
    disturbed_at_s: Numeric | None = None
    limit_cycle: LimitCycle = field(default_factory=LimitCycle)
    work: str = "absolute"
    has_oscillator: bool = True

    @cached_property
    def hops(self) -> Hops:
        """The table of all hops."""
        return hops(self.whole, self.rest_length_m)

    @cached_property
    def cycle(self) -> Settled:
        """The limit cycle of the undisturbed window."""
        return find_limit_cycle(self.hops, self.limit_cycle, -jnp.inf, self.trajectory.time_s[-1])

    @cached_property
    def regime(self) -> jax.Array:
        """Index into `REGIMES`, [lanes]."""
        failed = self.trajectory.failed[-1]
        time_s, end_s = self.hops.time_s, self.trajectory.time_s[-1]
        last_hop_s = jnp.max(jnp.where(time_s <= end_s[None], time_s, -jnp.inf), axis=0)
        rests = dies_out(last_hop_s, end_s)
        return jnp.where(
            failed,
            FAILED,
            jnp.where(self.on_cycle, LIMIT_CYCLE, jnp.where(rests, AT_REST, UNSETTLED)),
        )

    @cached_property
    def on_cycle(self) -> jax.Array:
        """True in lanes with a limit cycle, [lanes]."""
        return self.cycle.found & ~self.trajectory.failed[-1]

    @cached_property
    def start_s(self) -> jax.Array:
        """Beginning of the settled part [s], [lanes]; 0 without a limit cycle."""
        return jnp.where(self.on_cycle, self.cycle.time_s, 0.0)

    @cached_property
    def spectrum(self) -> Spectrum:
        """The height's, over the settled part."""
        first = jnp.floor(self.start_s / self.frame_s).astype(jnp.int32)
        return spectrum(self.trajectory.height_m, self.frame_s, first)

    @cached_property
    def peak(self) -> tuple[jax.Array, jax.Array]:
        """Frequency [rad/s] and A_peak of that spectrum's highest peak, [lanes] each."""
        return peak(self.spectrum)

    @cached_property
    def work_j(self) -> jax.Array:
        """The actuator's work over the last whole cycles [J], [lanes]."""
        return self.over_cycles(work_total(self.whole, self.work))

    def where_settled(self, value: Numeric) -> jax.Array:
        """The value [lanes], NaN in lanes without a limit cycle."""
        return jnp.where(self.on_cycle, value, jnp.nan)

    @cached_property
    def is_settled(self) -> jax.Array:
        """Mask of the frames of the window that belong to the settled part, [frames, lanes]."""
        return jnp.asarray(self.trajectory.time_s) >= self.start_s[None]

    def mean_where(self, values: AnyArray, holds: AnyArray | bool) -> jax.Array:
        """Mean of values [frames, lanes] over the settled frames in which something holds, [lanes].

        NaN where it holds in none.
        """
        counts = self.is_settled & holds
        total = jnp.sum(jnp.where(counts, values, 0.0), axis=0)
        number = jnp.sum(counts, axis=0).astype(total.dtype)
        return jnp.where(number > 0.0, total / jnp.maximum(number, 1.0), jnp.nan)

    def over_cycles(self, total: AnyArray) -> jax.Array:
        """Return the growth of a running total [frames, lanes] over the last whole cycles,
        [lanes]."""
        return self.hops.between(self.cycle.from_hop, self.cycle.to_hop, total)

    def apex_s(self, hop: AnyArray) -> jax.Array:
        """Time of the apex of each lane's hop of that number [s], [lanes]."""
        return at_frame(self.hops.time_s, hop)

    def settles_again(self, after_s: Numeric) -> Settled:
        """Find each lane's limit cycle between a time [s], [lanes], and the end of all frames."""
        return find_limit_cycle(self.hops, self.limit_cycle, after_s, self.whole.time_s[-1])


class ClampedEpisodes(NamedTuple):
    """Undisturbed episodes with the oscillator clamped to each of some phases: NumPy arrays.

    A lane is a run at a frequency, as in the episodes whose oscillator moves.
    """

    phases_rad: np.ndarray
    """The phases [rad], [phases]."""
    cycle: Settled
    """The limit cycle at each phase: arrays of shape [lanes, phases]."""
    failed: np.ndarray
    """True for episodes that had failed by the end, [lanes, phases]."""

    @property
    def on_cycle(self) -> np.ndarray:
        """Mask of the episodes that hop on a limit cycle, [lanes, phases]."""
        return np.isfinite(self.cycle.period) & ~self.failed


TABLE, FIGURE, REPORT = "table", "figure", "report"
PLACES = (TABLE, FIGURE, REPORT)
"""Outputs that can show a metric: tables on the screen, the study's figures, the report's page."""

REGIME = "regime"
"""A label of every episode beside its metrics: an index into `REGIMES`."""


@dataclass(frozen=True)
class Conditions:
    """Under what some episodes were measured.

    Args:
        body: the body; None where it is not known, as in a recording.
        work: definition of work, one of "absolute", "positive", "net".
        drop_m: how far the ground dropped [m]; 0 if it did not.
    """

    body: Body | None
    work: str = "absolute"
    drop_m: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Metric:
    """Description common to all metrics. The subclass decides the computation.

    Args:
        name: by which it is asked for, and its column in tables; with its unit, such as "t0_s".
        label: a short name for a person, such as "T0".
        about: its meaning in one line.
        more_is_better: whether more of it is better; None if neither is.
        unit: empty for a pure number.
        range: least and largest possible value; intervals do not reach beyond.
        math: the label in figures, where $...$ is mathematics; the plain label by default.
        shown: where it is shown unasked, of `PLACES`. Exported tables and documents hold all.
    """

    name: str
    label: str
    about: str
    more_is_better: bool | None
    unit: str = ""
    range: Range = UNBOUNDED
    math: str = ""
    shown: tuple[str, ...] = PLACES

    @classmethod
    def described(cls, **fields: Any) -> Callable[[Callable[..., Any]], Self]:
        """A decorator that makes a metric of the function that computes it.

        The function's name is the metric's, and the first line of its docstring the meaning.

        Args:
            fields: all other fields.

        Example:
            >>> @GaitMetric.described(label="first apex", unit="m", more_is_better=None)
            ... def first_apex_m(episode):
            ...     '''height of the first apex'''
            ...     return episode.hops.height_m[0]
            >>> first_apex_m.about
            'height of the first apex'
        """

        def wrap(compute: Callable[..., Any]) -> Self:
            text = (inspect.getdoc(compute) or "").partition("\n")[0]
            entries = {"name": compute.__name__, "about": text, "compute": compute}
            return cls(**entries, **fields)

        return wrap

    @property
    def heading(self) -> str:
        """The label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[object, ...]:
        """Pickle it by its place, as functions are: its own function may be a lambda."""
        place = _place_of(self)
        return super().__reduce_ex__(protocol) if place is None else (_imported, place)


def _place_of(metric: Metric) -> tuple[str, str] | None:
    """The module and the name in it that hold a metric; None if no module does."""
    for module, loaded in list(sys.modules.items()):
        for name, value in list(getattr(loaded, "__dict__", {}).items()):
            if value is metric:
                return module, name
    return None


def _imported(module: str, name: str) -> Metric:
    return getattr(importlib.import_module(module), name)


@dataclass(frozen=True, kw_only=True)
class GaitMetric(Metric):
    """A metric of a rollout's recording.

    Args:
        compute: function of an `Episode` to an array [lanes], NaN where undefined; it is compiled,
            so jnp functions only.
        channels: what it reads of the recording beside `HOP_CHANNELS`, such
            as "impulse_ns".
        parameters: what it needs beside the recording, of "omega" and "max_force_n".
        disturbed: whether it is about what comes after the ground drops.

    Example:
        >>> import jax.numpy as jnp
        >>> apex = GaitMetric(
        ...     name="mean_apex_m",
        ...     label="mean apex",
        ...     unit="m",
        ...     about="mean height of the apexes of the hops",
        ...     more_is_better=True,
        ...     compute=lambda episode: jnp.nanmean(episode.hops.height_m, axis=0),
        ... )
        >>> apex.heading
        'mean apex [m]'
    """

    compute: Callable[[Episode], jax.Array]
    channels: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    disturbed: bool = False


@dataclass(frozen=True, kw_only=True)
class ClampedMetric(Metric):
    """A metric of rollouts in which the oscillator stands still, at one phase after the other.

    It is undefined for a controller without oscillator.

    Args:
        compute: function of `ClampedEpisodes` to an array [lanes], NaN where undefined.
    """

    compute: Callable[[ClampedEpisodes], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class DerivedMetric(Metric):
    """A metric that follows from others of the same episode.

    Args:
        of: names of these, or `REGIME`.
        compute: function of their values, NumPy arrays of one shape by name, NaN where undefined,
            and of the `Conditions`; to an array of that shape.
        needs_body: whether it takes the body; undefined where that is not known.
    """

    of: tuple[str, ...]
    compute: Callable[[Mapping[str, np.ndarray], Conditions], np.ndarray]
    needs_body: bool = False

    def values(self, metrics: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
        """Its values, of those of other metrics, arrays of one shape."""
        inputs = {name: metrics[name] for name in self.of}
        if self.needs_body and conditions.body is None:
            return np.full(np.shape(next(iter(inputs.values()))), np.nan)
        return np.asarray(self.compute(inputs, conditions), float)
