"""All metrics of a gait at once: of rollouts, lane by lane; or of one recording, with the reason of
each that is undefined."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.transforms import jit_in_one_module
from tegotae.measures.hopping.hopping import Hops, LimitCycle, hops
from tegotae.measures.hopping.metrics import (
    AT_REST,
    FAILED,
    HOPPING,
    LIMIT_CYCLE,
    REGIME,
    WORK,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    Episode,
    GaitMetric,
    built_in_gait,
    channels_of,
    derived,
)
from tegotae.measures.hopping.recording import (
    TOTALS,
    Samples,
    checked_samples,
    denoised,
    frames_of,
    step_of,
)
from tegotae.measures.hopping.signals import FORCE_PERIOD_S, check_work, cot_inverse, work_total
from tegotae.measures.metric import Metric
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True, eq=False, repr=False)
class Gait:
    """The metrics of a gait, by name: `gait.t0_s`. Arrays of shape [lanes], NaN where undefined.

    There is every `GaitMetric` that was asked for, and `regime`, the index into `REGIMES`.

    Args:
        values: by name.

    Example:
        >>> Gait({"t0_s": 3.5}).t0_s
        3.5
    """

    values: Mapping[str, Any]

    def __getattr__(self, name: str) -> Any:
        # Before the values are there, as in a copy being made, nothing is.
        if name != "values" and name in self.values:
            return self.values[name]
        raise AttributeError(f"there is no metric {name!r} in this gait")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.values]

    def __repr__(self) -> str:
        return f"Gait({', '.join(f'{name}={value!r}' for name, value in self.values.items())})"

    def lane(self, number: int = 0) -> Gait:
        """Return the metrics of one lane as Python numbers."""
        return Gait({name: np.asarray(v)[number].item() for name, v in self.values.items()})

    def tree_flatten(self) -> tuple[tuple[Numeric, ...], tuple[str, ...]]:
        """Return the arrays and their names, for JAX."""
        return tuple(self.values.values()), tuple(self.values)

    @classmethod
    def tree_unflatten(cls, names: tuple[str, ...], arrays: Iterable[Numeric]) -> Gait:
        """Restore a gait from its arrays, the reverse of `tree_flatten`."""
        return cls(dict(zip(names, arrays, strict=True)))


_STATIC = ("frame_s", "undisturbed_s", "limit_cycle", "work", "has_oscillator", "metrics")


@partial(jit_in_one_module, static_names=_STATIC)
def gait(
    trajectory: Trajectory,
    *,
    undisturbed_s: float | None = None,
    metrics: tuple[GaitMetric, ...] | None = None,
    **settings: Any,
) -> Gait:
    """Return the metrics of every lane's gait.

    All but T1 are measured in the undisturbed window, from the release to `undisturbed_s`, and
    there on the settled part: from the first settled apex to the window's end. CoT⁻¹ is taken over
    its last whole cycles, from apex to apex. T1 needs a gait that was settled before the
    disturbance and settles again before the trajectory's end.

    Args:
        trajectory: frames of shape [frames, lanes], from the release on.
        undisturbed_s: end of the undisturbed window [s]; the whole trajectory if None.
        metrics: which; the package's own by default.
        settings: those of the `Episode`: `omega`, `rest_length_m`, `max_force_n` and `frame_s`, and
            as far as they are not the usual ones `disturbed_at_s`, `limit_cycle`, `work` and
            `has_oscillator`.

    Raises:
        TegotaeError: for an unknown definition of work, or a recording period of which 20 ms is no
            multiple (`smoothness`).
    """
    window = trajectory
    if undisturbed_s is not None:
        frames = int(undisturbed_s / settings["frame_s"] + 1e-6)
        window = jax.tree.map(lambda recorded: recorded[:frames], trajectory)
    episode = Episode(trajectory=window, whole=trajectory, **settings)
    selected = built_in_gait() if metrics is None else metrics
    return Gait({REGIME: episode.regime} | {m.name: m.compute(episode) for m in selected})


@dataclass(frozen=True, kw_only=True)
class GaitSummary:
    """The metrics of a rollout's gait, as a `Rollout`'s summary: `Gait` of arrays [lanes].

    Args:
        work: definition of work, one of "absolute", "positive", "net".
        metrics: which; the package's own by default.

    Example:
        >>> import numpy as np
        >>> from tegotae import Rollout, Scenario
        >>> from tegotae.systems.recipe import recipe
        >>> rollout = Rollout(controller=recipe("V-reflex-w8").controller(), summary=GaitSummary())
        >>> path = rollout.run(np.array([[2.0]]), Scenario(omega=8.0))
        >>> f"{path.limit_cycle_period[0]:.0f} {path.cot_inverse[0]:.2f} m/J"
        '1 0.43 m/J'
    """

    work: str = "absolute"
    metrics: tuple[GaitMetric, ...] | None = None

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that are recorded for it."""
        return channels_of(built_in_gait() if self.metrics is None else self.metrics)

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Gait:
        """Return the metrics, each of shape [lanes]."""
        return gait(
            trajectory,
            omega=scenario.omega,
            rest_length_m=body.rest_length_m,
            max_force_n=body.max_force_n,
            frame_s=timing.frame_s,
            disturbed_at_s=scenario.drop_time_s,
            work=self.work,
            metrics=self.metrics,
        )


_HOPS = 0.25  # of the swings; less is what hops of several heights make of a spectrum
_CLIMB = 0.1  # of the climb; less is what samples far apart cost
_BOUNCE = 0.01  # of the rest length a hop, which bounces that are no hops may climb


def _contradictions(
    frames: Trajectory, table: Hops, span: tuple[int, int], rest_length_m: float
) -> tuple[str, ...]:
    """Return a sentence for every two measurements of one quantity that contradict each other, as
    noise makes them do.

    From one apex to another, the height's spectrum shows how often the body swings, which is once
    a hop, or once in a few hops of different heights; and the apexes show how much was climbed in
    flight.

    Args:
        frames: the recording, [frames, 1].
        table: its hops, [hops].
        span: rows of the first and last of them.
        rest_length_m: rest length of the leg l0 [m].
    """
    first, last = (int(table.frame[row]) for row in span)
    count, swings = span[1] - span[0], _swings(frames.height_m[first : last + 1, 0])
    texts = []
    times = max(1.0, np.round(count / swings)) if swings else 1.0
    if abs(count - times * swings) > max(1.0, _HOPS * times * swings):
        texts.append(
            f"hops and spectrum contradict each other: {count} hops, while the height swings "
            f"{swings:.3g} times"
        )
    apexes = slice(span[0] + 1, span[1] + 1)
    over_ground = table.height_m[apexes] - frames.ground_m[table.frame[apexes], 0]
    by_hops = float(np.sum(over_ground - rest_length_m))
    climbed = float(frames.climb_flight_m[last, 0] - frames.climb_flight_m[first, 0])
    if abs(climbed - by_hops) > _CLIMB * by_hops + _BOUNCE * rest_length_m * count:
        texts.append(
            f"hops and climb contradict each other: {climbed:.3g} m climbed in flight, while the "
            f"apexes of {count} hops rise {by_hops:.3g} m over the rest length"
        )
    cause = (
        "noise, bounces too low to be hops, a wrong rest length or a wrong unit do that: look at "
        "--plot, or set --lowpass"
    )
    return (*texts, cause) if texts else ()


def _swings(height_m: np.ndarray) -> float:
    """Return the number of periods of a height's strongest frequency."""
    still = height_m - height_m.mean()
    power = np.abs(np.fft.rfft(np.hanning(len(still)) * still, 8 * len(still))) ** 2
    return float(np.argmax(power)) / 8.0


@dataclass(frozen=True)
class Efficiency:
    """Height climbed and work, from one apex to another."""

    start_s: float
    """Time of the first apex since the first sample [s]."""
    end_s: float
    """Time of the last apex [s]."""
    climb_flight_m: float
    """Heights climbed in flight [m]."""
    climb_m: float
    """Heights climbed in flight and in stance [m]."""
    work_j: float
    """The actuator's work [J]; NaN if neither it nor the force was recorded."""
    settled: bool
    """True for whole cycles of a limit cycle. If not, the value may depend on which hops were
    recorded: it is no metric of a gait."""
    cot_inverse: float
    """CoT⁻¹ of the heights climbed in flight [m/J]; NaN for unknown or negative work."""
    cot_inverse_total: float
    """CoT⁻¹ of all heights climbed [m/J]."""


@dataclass(frozen=True, eq=False, repr=False)
class Measured(Gait):
    """The metrics of one recording, floats by name, NaN where undefined: `measured.t0_s`.

    Example:
        >>> Measured({"t1_s": np.nan}, {"t1_s": "there was no disturbance"}, *[None] * 4).reasons
        {'t1_s': 'there was no disturbance'}
    """

    reasons: dict[str, str]
    """Reason of each metric that is NaN, by its name."""
    efficiency: Efficiency | None
    """Over the cycles of CoT⁻¹, or, of a gait that does not settle, over the hops of the second
    half of the recording. None with fewer than two."""
    frames: Trajectory
    """The recording in frames of 20 ms, [frames, 1]."""
    hops: Hops
    """Its hops, [hops] each."""
    omega: float
    """Prescribed frequency ω [rad/s]; NaN if it is not known."""
    notes: tuple[str, ...] = ()
    """Remarks on the numbers, a sentence each: which are the recorder's own, the noise and its
    treatment, and contradictions."""


_CLOCK_S = 1e6
"""A first time beyond this is the stamp of a clock, such as Unix's [s]."""


def measure(
    time_s: ArrayLike,
    height_m: ArrayLike,
    *,
    rest_length_m: float,
    omega: float | None = None,
    max_force_n: float | None = None,
    disturbed_at_s: float | None = None,
    limit_cycle: LimitCycle | None = None,
    lowpass_hz: float | None = None,
    work: str = "absolute",
    body: Body | None = None,
    **signals: ArrayLike | None,
) -> Measured:
    """Return the metrics of one recorded gait, from a robot or another simulator.

    The first sample is the release. What is missing leaves undefined (NaN) what needs it, and
    `reasons` says so: the force CoT⁻¹ and smoothness, the largest force smoothness, the prescribed
    frequency ΔΩ and Δw, the disturbance T1. A recording without any hop is no error: `regime` says
    so, CoT⁻¹ is zero and all else undefined. Work that is negative in sum leaves CoT⁻¹ undefined.

    Args:
        time_s: sampling times, uniform, at most 20 ms apart [s], shape [samples].
        height_m: height of the centre of mass y [m], [samples].
        rest_length_m: height over ground at which the foot leaves it, l0 [m].
        omega: prescribed frequency ω [rad/s].
        max_force_n: largest actuator force α [N].
        disturbed_at_s: when a disturbance, such as a drop of the ground, took place [s]; of time
            stamps, such as Unix's, from the first sample on.
        limit_cycle: what counts as settled; its tolerances are for a leg of 1 m, and are widened as
            far as noise hides smaller differences.
        lowpass_hz: cutoff of the zero-phase low-pass of the height [Hz]; infinite to filter
            nothing. By default a height with noise is filtered at the cutoff of least expected
            error, and one without noise is not (`tegotae.measures.hopping.recording`).
        work: definition of work, one of "absolute", "positive", "net".
        body: the body, for metrics that take it, such as the share of its optimum.
        more: further columns, [samples] or None, as for `from_samples`: `ground_m`, `phase_rad`,
            `force_n`; `work_j`, which is then not computed from the force (what a motor took from
            its battery, say); `climb_flight_m` and `climb_m`, likewise.

    Returns:
        The metrics as floats, with the reason of each that is undefined.

    Raises:
        TegotaeError: for a recording that `from_samples` refuses, samples more than 20 ms apart, a
            frequency that is not positive, or a disturbance outside of it.

    Example:
        >>> from tegotae.measures.hopping import REGIMES
        >>> time_s = np.arange(4000) * 0.005
        >>> found = measure(time_s, 1 + 0.1 * np.sin(6 * time_s), rest_length_m=1.0, omega=6.0)
        >>> REGIMES[found.regime], f"{found.w_peak:.2f} rad/s"
        ('limit cycle', '6.00 rad/s')
        >>> found.reasons["cot_inverse"]
        'neither the actuator force nor its work was recorded'
    """
    if omega is not None:
        require_finite("omega", omega, above=0.0, most=1e6)
    if max_force_n is not None:
        require_finite("max_force_n", max_force_n, above=0.0, most=1e9)
    check_work(work)
    samples = checked_samples({"time_s": time_s, "height_m": height_m, **signals}, rest_length_m)
    if step_of(samples) > 1.01 * FORCE_PERIOD_S:
        raise TegotaeError(
            f"the samples are {step_of(samples):g} s apart; the metrics need at least "
            f"{1 / FORCE_PERIOD_S:g} samples a second, or another unit of the times"
        )
    clean = denoised(
        samples,
        rest_length_m=rest_length_m,
        limit_cycle=limit_cycle or LimitCycle(),
        work=work,
        lowpass_hz=lowpass_hz,
    )
    limit_cycle, rest_length_m = clean.limit_cycle, float(rest_length_m)
    frames = frames_of(clean.samples, rest_length_m, FORCE_PERIOD_S, clean.prominence_m)
    began_s, ended_s = float(samples["time_s"][0]), float(frames.time_s[-1, 0])
    stamped = abs(began_s) > _CLOCK_S
    at_s = _since_release(disturbed_at_s, 0.0 if stamped else began_s, ended_s)
    end_s = ended_s if at_s is None else at_s
    with jax.enable_x64(True):
        of_gait = gait(
            frames,
            omega=np.nan if omega is None else float(omega),
            rest_length_m=rest_length_m,
            max_force_n=np.nan if max_force_n is None else float(max_force_n),
            frame_s=FORCE_PERIOD_S,
            undisturbed_s=at_s,
            disturbed_at_s=at_s,
            limit_cycle=limit_cycle,
            work=work,
            metrics=tuple(m for m in HOPPING.metrics() if isinstance(m, GaitMetric)),
        ).lane()
        table = _hops_of(frames, rest_length_m)
    # How far the ground dropped, if that was the disturbance, no recording says.
    conditions = Conditions(body, work, 0.0 if at_s is None else np.inf)
    follow = derived({name: np.asarray(x) for name, x in of_gait.values.items()}, conditions)
    values = {**of_gait.values, **{name: float(value) for name, value in follow.items()}}
    missing = _missing(samples, omega, max_force_n)
    if at_s is None:
        missing["disturbance"] = "there was no disturbance"
    if values[REGIME] != LIMIT_CYCLE:
        missing["cycle"] = _no_cycle(int(values[REGIME]), table, end_s, limit_cycle)
    if body is None:
        missing["body"] = "it takes the body, which is not given"
    undefined = {name for name, value in values.items() if np.isnan(value)}
    settles = values[REGIME] == LIMIT_CYCLE
    span = _span(table, end_s, of_gait.limit_cycle_period, of_gait.t0_s)
    stamps = f"times count from the first sample, stamped {began_s:.12g} s"
    return Measured(
        values,
        {
            metric.name: _why_undefined(metric, undefined, missing)
            for metric in HOPPING.metrics()
            if isinstance(metric, ClampedMetric) or metric.name in undefined
        },
        None if span is None else _efficiency(frames, table, span, work, settles),
        frames,
        table,
        np.nan if omega is None else float(omega),
        (
            *([stamps] if stamped else []),
            *_own_totals([name for name in TOTALS if name in samples]),
            *clean.notes,
            *([] if span is None else _contradictions(frames, table, span, rest_length_m)),
        ),
    )


def _hops_of(frames: Trajectory, rest_length_m: float) -> Hops:
    """Return the hops of the one lane, without rows after its last."""
    *table, count = (np.asarray(column) for column in hops(frames, rest_length_m))
    return Hops._make([*(column[: count[0], 0] for column in table), count[0]])


def _span(table: Hops, end_s: float, period: float, t0_s: float) -> tuple[int, int] | None:
    """Return the rows of the first and last hop of the last whole cycles up to an end [s].

    Without a limit cycle those of the second half; None with fewer than two.
    """
    last = int(np.sum(table.time_s <= end_s)) - 1
    if np.isfinite(period):
        turns = (last - np.searchsorted(table.time_s, t0_s)) // period
        return last - int(turns * period), last
    first = int(np.sum(table.time_s < 0.5 * end_s))
    return (first, last) if first < last else None


def _since_release(at_s: float | None, began_s: float, ended_s: float) -> float | None:
    """Return the time of the disturbance since the first sample [s]."""
    if at_s is None:
        return None
    require_finite("disturbed_at_s", at_s)
    at_s -= began_s
    if not 4 * FORCE_PERIOD_S <= at_s <= ended_s:
        raise TegotaeError(
            f"disturbed_at_s lies {at_s:g} s after the first sample; it must lie "
            f"inside the recording of {ended_s:g} s, and at least four frames "
            f"({4 * FORCE_PERIOD_S:g} s) after its start"
        )
    return at_s


def _own_totals(names: list[str]) -> list[str]:
    """Return a sentence on the running totals that replace numbers computed from samples."""
    listed = " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
    remark = "the recording's own running totals, not computed from its samples"
    return [f"{listed}: {remark}"] if names else []


def _efficiency(
    frames: Trajectory, table: Hops, span: tuple[int, int], work: str, is_cycle: bool
) -> Efficiency:
    first, last = (int(table.frame[row]) for row in span)
    totals = (frames.climb_flight_m, frames.climb_m, work_total(frames, work))
    flight, climb, work_j = (float(total[last, 0] - total[first, 0]) for total in totals)
    cot = [float(cot_inverse(x, work_j)) if work_j > -1e-6 else np.nan for x in (flight, climb)]
    start_s, end_s = (float(table.time_s[row]) for row in span)
    return Efficiency(start_s, end_s, flight, climb, work_j, is_cycle, *cot)


def _missing(samples: Samples, omega: float | None, max_force_n: float | None) -> dict[str, str]:
    """Return the reasons why channels and parameters of metrics are missing, by their names."""
    reasons: dict[str, str] = {}
    if "force_n" not in samples:
        unmoved = "neither the actuator force nor its work was recorded"
        reasons |= {} if "work_j" in samples else dict.fromkeys(WORK, unmoved)
        of_force = ("impulse_ns", "actuator_force_n")
        reasons |= dict.fromkeys(of_force, "the actuator force was not recorded")
    for channel in ("spring_force_n", "feedback_rad_per_s", "energy_j"):
        reasons[channel] = f"a recording has no {channel}"
    if omega is None:
        reasons["omega"] = "the prescribed frequency ω is not given"
    if max_force_n is None:
        reasons["max_force_n"] = "the largest actuator force α is not given"
    return reasons


def _why_undefined(metric: Metric, undefined: set[str], missing: Mapping[str, str]) -> str:
    """Return the reason why a metric has no value.

    Args:
        metric: the metric.
        undefined: names of all metrics without a value.
        missing: reasons by channel and parameter; and of `cycle`, `disturbance` and `body`.
    """
    if isinstance(metric, ClampedMetric):
        return "it takes simulations with the oscillator held still, which no recording is"
    if isinstance(metric, DerivedMetric):
        lacking = [f"{name} is undefined" for name in metric.of if name in undefined]
        lacking += [missing["body"]] if metric.needs_body and "body" in missing else []
        return next(iter(lacking), "it has no value for such a gait of this body")
    assert isinstance(metric, GaitMetric)
    if metric.disturbed and "disturbance" in missing:
        return missing["disturbance"]
    if "cycle" in missing:
        return missing["cycle"]
    for name, reason in missing.items():
        if name in (*metric.channels, *metric.parameters):
            return reason
    if metric.disturbed:
        return "the gait does not settle again before the recording ends"
    negative = set(metric.channels) & set(WORK)
    return "the work is negative in sum" if negative else "it has no value for this gait"


def _no_cycle(regime: int, table: Hops, end_s: float, limit_cycle: LimitCycle) -> str:
    """Return the reason why there is no limit cycle: the distance of the last hops from a
    repetition."""
    count, needed = int(np.sum(table.time_s <= end_s)), limit_cycle.min_repeats + 1
    if regime == FAILED:
        return "the body failed"
    if regime == AT_REST:
        return "no hop" if count == 0 else f"no hop after {table.time_s[count - 1]:.1f} s"
    if count < needed:
        return f"{count} hops; a limit cycle has to show at least {needed}"
    allowed = np.array([limit_cycle.height_tolerance_m, limit_cycle.phase_tolerance_rad])

    def spread(period: int) -> np.ndarray:
        """Return the distance of the last hops from the last cycle, in height [m] and phase
        [rad]."""
        rows = np.arange(count - needed * period, count)
        last = count - 1 - (count - 1 - rows) % period
        phase = table.phase_rad[rows] - table.phase_rad[last]
        turned = np.abs((phase + math.pi) % (2.0 * math.pi) - math.pi)
        return np.array([np.abs(table.height_m[rows] - table.height_m[last]).max(), turned.max()])

    periods = [k for k in range(1, limit_cycle.max_period + 1) if count >= needed * k]
    period = min(periods, key=lambda k: (spread(k) / allowed).max())
    far, units = spread(period), ((1e3, 3, "mm in height"), (1.0, 2, "rad in phase"))
    distances = [
        f"{scale * x:.{digits}g} {unit} ({scale * limit:g} are allowed)"
        for x, limit, (scale, digits, unit) in zip(far, allowed, units, strict=True)
        if x > limit
    ]
    if not distances:
        return f"the hops stop at {table.time_s[count - 1]:.1f} s, before the recording ends"
    every = "each other" if period == 1 else f"every {period} hops"
    return f"the last {needed * period} hops differ from {every} by {' and '.join(distances)}"
