"""Metrics of hopping: what they are computed from, their kinds, and the package's own.

The package's own stand at the end of the file, in the order in which tables show them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping import signals
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
from tegotae.measures.metric import REPORT, TABLE, Catalogue, Metric
from tegotae.measures.optimum import has_table, share
from tegotae.measures.statistics import POSITIVE, SHARE
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory

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
        """Return the value [lanes], NaN in lanes without a limit cycle."""
        return jnp.where(self.on_cycle, value, jnp.nan)

    @cached_property
    def is_settled(self) -> jax.Array:
        """Mask of the frames of the window that belong to the settled part, [frames, lanes]."""
        return jnp.asarray(self.trajectory.time_s) >= self.start_s[None]

    def mean_where(self, values: AnyArray, holds: AnyArray | bool) -> jax.Array:
        """Return the mean of values [frames, lanes] over those settled frames that meet a
        condition, [lanes].

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


REGIME = "regime"
"""A label of every episode beside its metrics: an index into `REGIMES`."""
HOPPING = Catalogue("hopping", REGIME)
"""The metrics of hopping."""


@dataclass(frozen=True)
class Conditions:
    """Conditions under which some episodes were measured.

    Args:
        body: the body; None where it is not known, as in a recording.
        work: definition of work, one of "absolute", "positive", "net".
        drop_m: how far the ground dropped [m]; 0 if it did not.
    """

    body: Body | None
    work: str = "absolute"
    drop_m: float = 0.0


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

    CATALOGUE: ClassVar[Catalogue] = HOPPING


@dataclass(frozen=True, kw_only=True)
class ClampedMetric(Metric):
    """A metric of rollouts in which the oscillator stands still, at one phase after the other.

    It is undefined for a controller without oscillator.

    Args:
        compute: function of `ClampedEpisodes` to an array [lanes], NaN where undefined.
    """

    compute: Callable[[ClampedEpisodes], np.ndarray]

    CATALOGUE: ClassVar[Catalogue] = HOPPING


@dataclass(frozen=True, kw_only=True)
class DerivedMetric(Metric):
    """A metric that is computed from others of the same episode.

    Args:
        of: names of these, or `REGIME`.
        compute: function of their values, NumPy arrays of one shape by name, NaN where undefined,
            and of the `Conditions`; to an array of that shape.
        needs_body: whether it takes the body; undefined where that is not known.
    """

    of: tuple[str, ...]
    compute: Callable[[Mapping[str, np.ndarray], Conditions], np.ndarray]
    needs_body: bool = False

    CATALOGUE: ClassVar[Catalogue] = HOPPING

    @property
    def sources(self) -> tuple[str, ...]:
        return tuple(name for name in self.of if name != REGIME)

    def values(self, metrics: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
        """Return the metric's values, from those of other metrics, arrays of one shape."""
        inputs = {name: metrics[name] for name in self.of}
        if self.needs_body and conditions.body is None:
            return np.full(np.shape(next(iter(inputs.values()))), np.nan)
        return np.asarray(self.compute(inputs, conditions), float)


def built_in_gait() -> tuple[GaitMetric, ...]:
    """Return the package's own metrics of a gait's recording. They are compiled together."""
    return tuple(metric for metric in HOPPING.built_in if isinstance(metric, GaitMetric))


def channels_of(selected: Iterable[Metric]) -> tuple[str, ...]:
    """Return the channels of a recording from which some metrics are computed."""
    further = (channel for m in selected if isinstance(m, GaitMetric) for channel in m.channels)
    return tuple(dict.fromkeys((*HOP_CHANNELS, *further)))


def with_needed(requested: Iterable[Metric]) -> tuple[Metric, ...]:
    """Return metrics behind those that they follow from."""
    needed: dict[str, Metric] = {}
    for metric in requested:
        for source in with_needed(HOPPING.find(name) for name in metric.sources):
            needed.setdefault(source.name, source)
        needed.setdefault(metric.name, metric)
    return tuple(needed.values())


def derived(values: Mapping[str, np.ndarray], conditions: Conditions) -> dict[str, np.ndarray]:
    """Compute the metrics of some episodes that are not among their values but follow from them.

    Args:
        values: of metrics, by name, arrays of one shape: a value an episode, not means of several.
        conditions: under which they were measured.

    Example:
        >>> from tegotae import Hopper
        >>> gait = {"cot_inverse": 0.6, "hop_rate": 4.0, "limit_cycle_period": 1}
        >>> gait = {name: np.array([value]) for name, value in gait.items()}
        >>> found = derived(gait, Conditions(Hopper()))
        >>> sorted(found), f"{found['optimum_share'][0]:.2f}"
        (['optimum_share'], '0.50')
    """
    results = dict(values)
    for metric in with_needed(m for m in HOPPING.metrics() if isinstance(m, DerivedMetric)):
        if not isinstance(metric, DerivedMetric) or metric.name in results:
            continue
        if results.keys() >= {*metric.of}:
            results[metric.name] = metric.values(results, conditions)
    return {name: results[name] for name in results if name not in values}


Values = Mapping[str, np.ndarray]
"""Values of other metrics by name, of one shape."""

WORK = ("work_absolute_j", "work_positive_j", "work_net_j")
"""The channels of the actuator's work, by every definition."""


def _over_cycles(episode: Episode, climbed_m: AnyArray) -> jax.Array:
    """Return CoT⁻¹ over whole cycles [m/J], from a running total of climbed heights [m], [frames,
    lanes].

    Zero for a body at rest or one that does no work, and undefined without a limit cycle.
    """
    work = episode.work_j
    efficiency = signals.cot_inverse(episode.over_cycles(climbed_m), work)
    # Negative work (and work that was not recorded) has no efficiency.
    value = jnp.where(work > -1e-6, efficiency, jnp.nan)
    return jnp.where(episode.regime == AT_REST, 0.0, episode.where_settled(value))


# Source: paper equation 12, the variant A of Fig. 4.
@GaitMetric.described(
    label="CoT⁻¹",
    unit="m/J",
    more_is_better=True,
    range=POSITIVE,
    channels=(*WORK, "climb_flight_m"),
)
def cot_inverse(episode: Episode) -> jax.Array:
    """height climbed in flight per work, over the settled part (equation 12)"""
    return _over_cycles(episode, episode.whole.climb_flight_m)


# Source: of this library (`tegotae.measures.optimum`).
@DerivedMetric.described(
    label="of optimum",
    more_is_better=True,
    range=POSITIVE,
    of=("cot_inverse", "hop_rate", "limit_cycle_period"),
    needs_body=True,
)
def optimum_share(values: Values, conditions: Conditions) -> np.ndarray:
    """CoT⁻¹ over the largest that any force can have at the gait's own hop rate"""
    cot, rate = values["cot_inverse"], values["hop_rate"]
    if not has_table(conditions.body, conditions.work):
        return np.full(np.shape(cot), np.nan)
    return share(cot, rate, values["limit_cycle_period"])


# Source: paper equation 12, the variant B of Fig. 4.
@GaitMetric.described(
    label="CoT⁻¹ B",
    unit="m/J",
    more_is_better=True,
    range=POSITIVE,
    channels=(*WORK, "climb_m"),
    shown=(TABLE, REPORT),
)
def cot_inverse_total(episode: Episode) -> jax.Array:
    """height climbed in flight and in stance per work, over the settled part"""
    return _over_cycles(episode, episode.whole.climb_m)


# Source: paper IV-A, T0.
@GaitMetric.described(label="T0", unit="s", more_is_better=False, range=POSITIVE)
def t0_s(episode: Episode) -> jax.Array:
    """time from release until settled"""
    return episode.where_settled(episode.cycle.time_s)


# Source: paper IV-A, T1.
@GaitMetric.described(label="T1", unit="s", more_is_better=False, range=POSITIVE, disturbed=True)
def t1_s(episode: Episode) -> jax.Array:
    """time from the first touchdown after a drop of the ground until settled again"""
    if episode.disturbed_at_s is None:
        return jnp.full_like(episode.cycle.time_s, jnp.nan)
    touchdowns = jnp.asarray(episode.whole.touchdown_time_s)
    later = touchdowns > jnp.asarray(episode.disturbed_at_s, touchdowns.dtype).reshape(1, -1)
    touchdown = jnp.min(jnp.where(later, touchdowns, jnp.inf), axis=0)
    again = episode.settles_again(touchdown)
    fell = episode.whole.failed[-1]
    return episode.where_settled(jnp.where(fell, jnp.nan, again.time_s - touchdown))


# Source: paper equation 13.
@GaitMetric.described(
    label="ΔΩ",
    unit="rad²/s²",
    more_is_better=True,
    range=(-float("inf"), 0.0),
    channels=("height_m",),
    parameters=("omega",),
    shown=(TABLE, REPORT),
)
def delta_omega(episode: Episode) -> jax.Array:
    """deviation from a pure oscillation at ω (equation 13)"""
    if not episode.has_oscillator:  # no prescribed frequency to deviate from, as in the fitness
        return episode.where_settled(jnp.zeros_like(episode.cycle.time_s))
    return episode.where_settled(signals.delta_omega(episode.omega, *episode.peak))


# Source: paper equation 14.
@GaitMetric.described(
    label="Δw",
    unit="rad/s",
    more_is_better=False,
    range=POSITIVE,
    channels=("height_m",),
    parameters=("omega",),
)
def delta_w(episode: Episode) -> jax.Array:
    """distance of the spectrum's peaks from ω (equation 14)"""
    return episode.where_settled(signals.delta_w(episode.spectrum, episode.omega))


# Source: paper IV-A.
@ClampedMetric.described(label="CPGu", more_is_better=None, range=SHARE)
def cpgu(clamped: ClampedEpisodes) -> np.ndarray:
    """share of clamped phases without a limit cycle: 1 depends fully on the oscillator"""
    return 1.0 - clamped.on_cycle.mean(axis=-1)


# Source: of this library; the paper (IV-A) asks for a limit cycle of any period.
@GaitMetric.described(
    label="period", unit="hops", more_is_better=None, range=(1.0, float("inf")), shown=()
)
def limit_cycle_period(episode: Episode) -> jax.Array:
    """hops after which the limit cycle repeats itself"""
    return episode.where_settled(episode.cycle.period)


# Source: of this library; the paper (IV-A) asks of every episode whether a limit cycle forms.
@DerivedMetric.described(label="limit cycles", more_is_better=True, range=SHARE, of=(REGIME,))
def limit_cycle_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes with a limit cycle"""
    return (values[REGIME] == LIMIT_CYCLE).astype(float)


# Source: paper IV-A, on T1: "new limit cycle formation, if any".
@DerivedMetric.described(
    label="recovers",
    more_is_better=True,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "t1_s"),
)
def recovery_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the settled episodes that settle again after a drop of the ground"""
    tested = (values["limit_cycle_share"] == 1.0) & (conditions.drop_m > 0.0)
    return np.where(tested, np.isfinite(values["t1_s"]), np.nan)


# Source: of this library.
@DerivedMetric.described(label="failed", more_is_better=False, range=SHARE, shown=(), of=(REGIME,))
def failed_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes in which the body fails before it is disturbed"""
    return (values[REGIME] == FAILED).astype(float)


# Source: of this library; such an episode has no limit cycle, and a CoT⁻¹ of zero.
@DerivedMetric.described(
    label="at rest",
    more_is_better=False,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "cot_inverse"),
)
def at_rest_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes in which the body no longer hops before it is disturbed"""
    # Of what does not settle, a body at rest alone has a CoT⁻¹.
    rests = (values["limit_cycle_share"] == 0.0) & (values["cot_inverse"] == 0.0)
    return rests.astype(float)


# Source: of this library; the paper (V) calls actuation smooth and gives no measure.
@GaitMetric.described(
    label="dF/dt",
    unit="1/s",
    more_is_better=False,
    range=POSITIVE,
    channels=("impulse_ns",),
    parameters=("max_force_n",),
    shown=(TABLE, REPORT),
)
def smoothness(episode: Episode) -> jax.Array:
    """root-mean-square rate of change of the actuator force over its largest value"""
    impulse_ns = episode.trajectory.impulse_ns
    value = signals.smoothness(impulse_ns, episode.max_force_n, episode.frame_s, episode.start_s)
    return episode.where_settled(value)


# Source: paper equation 13, w_peak.
@GaitMetric.described(
    label="w peak",
    math=r"$w_\mathrm{peak}$",
    unit="rad/s",
    more_is_better=None,
    range=POSITIVE,
    channels=("height_m",),
    shown=(),
)
def w_peak(episode: Episode) -> jax.Array:
    """frequency of the highest peak of the height's spectrum, over the settled part"""
    return episode.where_settled(episode.peak[0])


# Source: paper equation 13, A_peak.
@GaitMetric.described(
    label="A peak",
    math=r"$A_\mathrm{peak}$",
    more_is_better=None,
    range=SHARE,
    channels=("height_m",),
    shown=(),
)
def a_peak(episode: Episode) -> jax.Array:
    """square root of the power's share in the spectrum's highest peak"""
    return episode.where_settled(episode.peak[1])


# Source: of this library.
@GaitMetric.described(
    label="hop rate", unit="rad/s", more_is_better=None, range=POSITIVE, shown=(TABLE, REPORT)
)
def hop_rate(episode: Episode) -> jax.Array:
    """2π times hops over time, over the cycles of CoT⁻¹"""
    cycle = episode.cycle
    cycles_s = episode.apex_s(cycle.to_hop) - episode.apex_s(cycle.from_hop)
    hops_s = cycles_s / (cycle.to_hop - cycle.from_hop).astype(cycles_s.dtype)
    return episode.where_settled(2.0 * jnp.pi / hops_s)


# Source: of this library, for the paper's "switches off the oscillator feedback mechanism" (V).
@GaitMetric.described(
    label="by feedback",
    more_is_better=None,
    range=SHARE,
    channels=("feedback_rad_per_s",),
    parameters=("omega",),
    shown=(REPORT,),
)
def feedback_share(episode: Episode) -> jax.Array:
    """size of the feedback, mean |f| over ω + mean |f|

    Over the settled part: 0 if the feedback is off.
    """
    feedback = jnp.abs(jnp.asarray(episode.trajectory.feedback_rad_per_s))
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    mean = episode.mean_where(feedback, True)
    return episode.where_settled(mean / (jnp.asarray(episode.omega) + mean))


_BINS = 12
"""Number of bins of the spring force, from zero to its largest value; the force may follow a line
in each."""

_STILL = 1e-3
"""A force that varies less than this, over its own size, has no variance to be explained."""


# Source: of this library, for the paper's "independence of the actuation instant from the
# oscillator state, while the actuation force is solely modulated by F_k" (V).
@GaitMetric.described(
    label="by phase",
    more_is_better=None,
    range=SHARE,
    channels=("spring_force_n", "actuator_force_n"),
    shown=(REPORT,),
)
def phase_share(episode: Episode) -> jax.Array:
    """share of the force's variance in stance left beside a line in each of 12 bins of F_k

    All in stance of the settled part: about E[Var(F_a | F_k)] / Var(F_a).

    On a limit cycle the force is a function of the place in the cycle. What it has at one F_k in
    different ways (while the leg is compressed, and while it extends) it has by the phase, if the
    controller senses F_k alone.
    """
    path = episode.trajectory
    felt, force = jnp.asarray(path.spring_force_n), jnp.asarray(path.actuator_force_n)
    if not episode.has_oscillator:
        return jnp.full(felt.shape[1:], jnp.nan)
    stance = felt > 0.0
    size = episode.mean_where(force**2, stance)
    force = force - episode.mean_where(force, stance)[None]
    largest = jnp.max(jnp.where(episode.is_settled & stance, felt, 0.0), axis=0)
    place = _BINS * felt / jnp.where(largest > 0.0, largest, 1.0)[None]
    number = jnp.clip(jnp.floor(place), 0, _BINS - 1)
    place = place - number - 0.5

    def residual(bin_number: jax.Array) -> jax.Array:
        """Return the variance in one bin beside a line, over that of all of stance."""
        inside = stance & (number == bin_number)
        share = episode.mean_where(inside.astype(force.dtype), stance)

        def mean(values: jax.Array) -> jax.Array:
            return jnp.nan_to_num(episode.mean_where(values, inside))

        x, y = place - mean(place)[None], force - mean(force)[None]
        spread = mean(x * x)
        slope = jnp.where(spread > 0.0, mean(x * y) / jnp.where(spread > 0.0, spread, 1.0), 0.0)
        return share * mean((y - slope[None] * x) ** 2)

    unexplained = jnp.sum(jax.lax.map(residual, jnp.arange(_BINS, dtype=place.dtype)), axis=0)
    variance = episode.mean_where(force**2, stance)
    share = unexplained / jnp.where(variance > _STILL**2 * size, variance, jnp.nan)
    return episode.where_settled(jnp.clip(share, 0.0, 1.0))


# Source: of this library, for the paper's "the oscillator is slowed down during actuation" (V).
@GaitMetric.described(
    label="f pushing",
    unit="rad/s",
    more_is_better=None,
    channels=("feedback_rad_per_s", "actuator_force_n"),
    shown=(),
)
def feedback_while_pushing(episode: Episode) -> jax.Array:
    """mean feedback while the actuator pushes; below zero it slows the oscillator"""
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    pushes = jnp.asarray(episode.trajectory.actuator_force_n) > 0.0
    return episode.where_settled(episode.mean_where(feedback, pushes))


HOPPING.built_in = tuple(x for x in tuple(globals().values()) if isinstance(x, Metric))
