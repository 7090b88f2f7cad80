"""The paper's evaluation of trained or hand-made controllers: five frequencies, a drop, a clamp."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_M, MOST_POINTS, MOST_RAD_PER_S
from tegotae.measures.hopping.episode import ClampedEpisodes
from tegotae.measures.hopping.gait import gait
from tegotae.measures.hopping.hopping import Hops, LimitCycle, Settled, hops, settled
from tegotae.measures.hopping.metric import (
    REGIME,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.measures.hopping.registry import (
    built_in_gait,
    channels_of,
    chosen,
    summarise,
    with_needed,
)
from tegotae.measures.hopping.signals import check_work, require_measurable
from tegotae.measures.hopping.statistics import Interval, mean_defined
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body, Hopper, require_one_limb
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import Clamped
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.rollout import (
    Engine,
    Scenario,
    Timing,
    Trajectory,
    check_senses,
)

CONTINUOUS = PredictorCorrector()
"""Time as the paper has it: the controller is not held over a control period."""


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """How controllers are evaluated.

    One episode per frequency: undisturbed for `undisturbed_s`, and then the ground drops at the
    next apex of a hop, that is, in flight. T1 is measured over what is left.

    Args:
        offsets: the episodes' frequencies relative to ω_t [rad/s].
        undisturbed_s: undisturbed time from the release on [s].
        disturbed_s: time after that [s], of which the wait for an apex is part.
        drop_m: how far the ground drops [m]; 0 leaves T1 undefined.
        clamped_phases: at how many equidistant phases the oscillator is clamped for CPGu.
        limit_cycle: what counts as settled.
        work: definition of work, one of "absolute", "positive", "net".
        tick_s: control period [s].
        release_m: height of the release [m].

    Raises:
        TegotaeError: for a time or a height that is not positive, a negative drop, no episode, or
            an unknown definition of work.

    Source: paper IV-A, on T1 and CPGu, and IV-B, on the five frequencies; what these leave open is
    in docs/reproduction/fidelity.
    """

    offsets: tuple[float, ...] = (-2.0, -1.0, 0.0, 1.0, 2.0)
    undisturbed_s: float = 40.0
    disturbed_s: float = 40.0
    drop_m: float = 0.2
    clamped_phases: int = 6
    limit_cycle: LimitCycle = field(default_factory=LimitCycle)
    work: str = "absolute"
    tick_s: float = 0.001
    release_m: float = 1.2

    def __post_init__(self) -> None:
        if not self.offsets:
            raise TegotaeError("offsets is empty; give at least one, such as 0")
        for offset in self.offsets:
            require_finite("an offset of the frequency", offset)
        require_finite("undisturbed_s", self.undisturbed_s, least=1.0)
        require_finite("disturbed_s", self.disturbed_s, least=1.0)
        require_finite("drop_m", self.drop_m, least=0.0, most=MOST_M)
        require_finite("release_m", self.release_m, above=0.0, most=MOST_M)
        require_count("clamped_phases", self.clamped_phases, most=MOST_POINTS)
        check_work(self.work)

    def omegas(self, controller: Controller, omega_t: float | None) -> tuple[float, ...]:
        """The frequencies of the episodes [rad/s]; a single NaN without an oscillator.

        Raises:
            TegotaeError: for an oscillator without ω_t, or a frequency that is not positive.
        """
        if controller.oscillator is None:
            return (math.nan,)
        if omega_t is None:
            raise TegotaeError("a controller with an oscillator needs omega_t, such as 8 (rad/s)")
        require_finite("omega_t", omega_t, above=0.0, most=MOST_RAD_PER_S)
        omegas = tuple(omega_t + offset for offset in self.offsets)
        if min(omegas) <= 0.0:
            raise TegotaeError(
                f"omega_t is {omega_t:g} and its lowest offset {min(self.offsets):g}; every "
                "frequency must be greater than 0 rad/s"
            )
        return omegas


class Releases(NamedTuple):
    """From where each run is released, at rest: arrays of shape [runs]."""

    height_m: np.ndarray
    """Height [m]."""
    phase_rad: np.ndarray
    """Phase of the oscillator [rad]."""


def drawn_releases(runs: int, height_m: float, *, spread_m: float = 0.1, seed: int = 0) -> Releases:
    """The standard release (phase 0), and others drawn around it.

    Args:
        runs: how many in all.
        height_m: height of the standard release [m].
        spread_m: how far the others are above or below it at most [m]; their phases are anywhere.
        seed: of the draw.

    Example:
        >>> drawn_releases(3, 1.2).height_m.round(2).tolist()
        [1.2, 1.15, 1.11]
    """
    draw = np.random.default_rng(seed)
    height = height_m + draw.uniform(-spread_m, spread_m, runs)
    phase = draw.uniform(0.0, 2.0 * np.pi, runs)
    height[0], phase[0] = height_m, 0.0
    return Releases(height, phase)


@dataclass(frozen=True)
class Evaluation:
    """What an evaluation found, episode by episode. NaN is undefined everywhere.

    Args:
        protocol: how it was found.
        omega: frequencies of the episodes [rad/s], shape [episodes]; NaN without an oscillator.
        episodes: the metrics that were asked for, by name, shape [runs, episodes].
        recording: the channels that were asked for, of the undisturbed part, [frames, runs,
            episodes]; empty if none were.
    """

    protocol: Protocol
    omega: np.ndarray
    episodes: dict[str, np.ndarray]
    recording: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def n_runs(self) -> int:
        """How many runs (weight vectors) were evaluated."""
        return len(next(iter(self.episodes.values())))

    def runs(self) -> dict[str, np.ndarray]:
        """The metrics of every run, shape [runs]: means over its episodes.

        Episodes in which a metric is undefined do not enter its mean; `limit_cycle_share`,
        `recovery_share` and `failed_share` say how many those are. A metric that no episode
        defines is NaN.
        """
        return {name: mean_defined(values) for name, values in self.episodes.items()}

    def summary(self, *, seed: int = 0) -> dict[str, Interval]:
        """Mean over runs of each metric, with its spread and 95 % interval."""
        return summarise(self.runs(), seed=seed)

    def to_dict(self) -> JsonObject:
        """Everything, ready for JSON: numbers, lists and null where undefined.

        Every metric by name holds its mean over runs; `spread`, `interval_95` and `defined_runs`
        say how sure it is, `runs` and `episodes` what it is made of.
        """
        summary = self.summary()
        document = {
            **{name: found.mean for name, found in summary.items()},
            "spread": {name: found.std for name, found in summary.items()},
            "interval_95": {name: (found.low, found.high) for name, found in summary.items()},
            "defined_runs": {name: found.count for name, found in summary.items()},
            "n_runs": self.n_runs,
            "omega_rad_per_s": self.omega,
            "runs": self.runs(),
            "episodes": self.episodes,
            "protocol": dataclasses.asdict(self.protocol),
        }
        return {name: as_json(entry) for name, entry in document.items()}


def evaluate(
    controller: Controller,
    weights: ArrayLike,
    omega_t: float | None,
    body: Body | None = None,
    protocol: Protocol | None = None,
    releases: Releases | None = None,
    metrics: Iterable[str | Metric] | None = None,
    recorded: Sequence[str] = (),
    *,
    start: Scenario | None = None,
    integrator: Integrator | None = None,
) -> Evaluation:
    """Evaluate runs of a controller as the paper does (IV-B): every run at every frequency.

    All runs and frequencies are lanes of one batch. A rollout to find each lane's first apex after
    the undisturbed time goes before the one in which the ground drops there. Clamped to each of six
    phases the controllers are then rolled out undisturbed: CPGu is the share of phases at which
    none hops on a limit cycle. What no metric asked for needs is not rolled out.

    A controller without an oscillator has no prescribed frequency: one episode, ΔΩ of zero as in
    its fitness, and undefined Δw and CPGu.

    Args:
        controller: what drives the body.
        weights: one row per run, shape [runs, n_weights] or [n_weights].
        omega_t: training frequency ω_t [rad/s]; None without an oscillator.
        body: the body; the paper's hopper by default.
        protocol: episodes, drop, tolerances.
        releases: from where each run is released; the protocol's release for all by default.
        metrics: names of the metrics that are asked for; all that there are by default.
        recorded: names of channels whose undisturbed part is returned, too; none by default.
        start: what else a release has than its height: velocity, phase, pose and oscillator state;
            at rest and at phase 0 by default.
        integrator: how controller and body advance by a control period; in continuous time by
            default.

    Raises:
        TegotaeError: for weights of the wrong shape or not finite, a missing or non-positive
            frequency, releases of another number, a metric or channel that is not there, or what
            `require_evaluable` refuses.

    Example:
        >>> from tegotae.systems.models import find
        >>> model = find("V-reflex-w8")
        >>> found = evaluate(
        ...     model.controller(), [[2.0]], model.omega_t, metrics=["cot_inverse"]
        ... )
        >>> f"{found.summary()['cot_inverse'].mean:.2f} m/J"
        '0.44 m/J'
    """
    body = Hopper() if body is None else body
    protocol = protocol or Protocol()
    asked = chosen(metrics)
    require_evaluable(controller, body, protocol)
    omegas = np.array(protocol.omegas(controller, omega_t))
    weights = _checked_weights(controller, weights)
    runs, episodes = len(weights), len(omegas)
    lanes = np.repeat(weights, episodes, axis=0)
    start = Scenario(0.0) if start is None else start
    integrator = CONTINUOUS if integrator is None else integrator
    if releases is None:
        phase_rad = np.full(runs, float(start.phase_rad))
        releases = Releases(np.full(runs, protocol.release_m), phase_rad)
    if any(np.shape(entry) != (runs,) for entry in releases):
        raise TegotaeError(
            f"releases have shapes {[np.shape(entry) for entry in releases]}; {runs} runs need "
            f"one height and one phase each"
        )
    scenario = start._replace(
        omega=np.tile(omegas, runs),
        height_m=np.repeat(releases.height_m, episodes),
        phase_rad=np.repeat(releases.phase_rad, episodes),
    )

    values: dict[str, np.ndarray] = {}
    recording: dict[str, np.ndarray] = {}
    needed = with_needed(asked)
    of_gait = [metric for metric in needed if isinstance(metric, GaitMetric)]
    derived = [metric for metric in needed if isinstance(metric, DerivedMetric)]
    of_clamped = [metric for metric in needed if isinstance(metric, ClampedMetric)]
    if of_gait or derived or recorded:
        of_lanes, recording = _of_gait(
            controller, lanes, scenario, body, protocol, integrator, of_gait, recorded
        )
        values |= of_lanes
    if of_clamped:
        rest = scenario, body, protocol, integrator
        values |= _of_clamped(controller, lanes, *rest, of_clamped)
    conditions = Conditions(body, protocol.work, protocol.drop_m)
    for metric in derived:
        values[metric.name] = metric.values(values, conditions)
    episodes_of = {m.name: _per_lane(m, values[m.name], len(lanes)) for m in asked}
    return Evaluation(
        protocol,
        omegas,
        {name: value.reshape(runs, episodes) for name, value in episodes_of.items()},
        {name: value.reshape(-1, runs, episodes) for name, value in recording.items()},
    )


def require_evaluable(controller: Controller, body: Body, protocol: Protocol) -> None:
    """Raise `TegotaeError` if a controller on a body cannot be evaluated: before long work starts.

    That is: if they do not go together, the control period is too long for the body or no part of
    20 ms, or the body has several limbs, for whose gaits there are no metrics.

    Args:
        controller: what drives the body.
        body: the body.
        protocol: how it would be evaluated.
    """
    check_senses(controller, body)
    body.check_tick(protocol.tick_s)
    require_measurable(protocol.tick_s)
    try:
        require_one_limb(body, "the evaluation of hopping")
    except TegotaeError as error:
        raise TegotaeError(f"{error}; tegotae evaluate takes legs by their gaits") from None


def _of_gait(
    controller: Controller,
    weights: np.ndarray,
    scenario: Scenario,
    body: Body,
    protocol: Protocol,
    integrator: Integrator,
    metrics: Sequence[GaitMetric],
    recorded: Sequence[str],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Metrics of every lane's recording, [lanes] each by name, and the regime; some channels of it.

    The channels are those of the undisturbed part, [frames, lanes]. Where a metric is about it, the
    ground drops at the first apex after that.
    """
    own = built_in_gait()
    channels = channels_of((*own, *metrics))
    if channels is not None:
        channels = tuple(dict.fromkeys((*channels, *recorded)))
    given = controller, weights, scenario, body, protocol, channels
    if any(metric.disturbed for metric in metrics):
        trajectory, drop_time_s = disturbed_rollout(*given, integrator)
    else:
        trajectory, drop_time_s = _undisturbed(*given, integrator), None
    # The package's own are always computed together, by one program, whatever else is asked for:
    # their numbers do not depend on which others there are.
    users = tuple(metric for metric in metrics if metric not in own)
    found: dict[str, np.ndarray] = {}
    for together in (own, users) if users else (own,):
        measured = gait(
            trajectory,
            omega=jnp.asarray(scenario.omega, "float32"),
            rest_length_m=body.rest_length_m,
            max_force_n=body.max_force_n,
            frame_s=Timing().frame_s,
            undisturbed_s=protocol.undisturbed_s,
            disturbed_at_s=drop_time_s,
            limit_cycle=protocol.limit_cycle,
            work=protocol.work,
            has_oscillator=controller.oscillator is not None,
            metrics=together,
        )
        found |= {name: np.asarray(value, float) for name, value in measured.values.items()}
    values = {name: found[name] for name in (REGIME, *(metric.name for metric in metrics))}
    undisturbed = slice(round(protocol.undisturbed_s / Timing().frame_s))
    return values, {name: getattr(trajectory, name)[undisturbed] for name in recorded}


def _per_lane(metric: Metric, values: np.ndarray, lanes: int) -> np.ndarray:
    if np.shape(values) != (lanes,):
        raise TegotaeError(
            f"the metric {metric.name} gave an array of shape {np.shape(values)} for {lanes} "
            "lanes; it must give one number a lane (tegotae.check_metric tries it)"
        )
    return values


@dataclass(frozen=True)
class _Kept:
    """The trajectory's channels that are needed, as an `Engine`'s summary."""

    needs: tuple[str, ...] | None

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Trajectory:
        return trajectory


def _undisturbed(
    controller: Controller,
    weights: ArrayLike,
    scenario: Scenario,
    body: Body,
    protocol: Protocol,
    channels: tuple[str, ...] | None = None,
    integrator: Integrator = CONTINUOUS,
) -> Trajectory:
    """The undisturbed part of the episodes alone."""
    timing = Timing(duration_s=protocol.undisturbed_s, tick_s=protocol.tick_s)
    # Without an oscillator the frequency has no effect, but must be a number.
    driven = scenario._replace(omega=np.nan_to_num(scenario.omega))
    engine = Engine(
        controller=controller, timing=timing, summary=_Kept(channels), integrator=integrator
    )
    return engine.run(weights, driven, body)


def disturbed_rollout(
    controller: Controller,
    weights: ArrayLike,
    scenario: Scenario,
    body: Body,
    protocol: Protocol,
    channels: tuple[str, ...] | None = None,
    integrator: Integrator = CONTINUOUS,
) -> tuple[Trajectory, np.ndarray | None]:
    """Episodes in which the ground drops at the first apex of a hop after the undisturbed time.

    Where that apex lies is known only from a rollout, so each episode is rolled out twice: without
    the drop, and with it.

    Args:
        controller: what drives the body.
        weights: shape [lanes, n_weights].
        scenario: frequencies ω [rad/s], NaN without an oscillator, and releases.
        body: the body.
        protocol: times, size of the drop, control period.
        channels: which are recorded; all by default.
        integrator: how controller and body advance by a control period.

    Returns:
        The trajectory, arrays of shape [frames, lanes], and when the ground dropped [s], [lanes]:
        infinite in lanes that hop no more, None if the protocol has no drop.
    """
    timing = Timing(
        duration_s=protocol.undisturbed_s + protocol.disturbed_s, tick_s=protocol.tick_s
    )
    engine = Engine(
        controller=controller, timing=timing, summary=_Kept(channels), integrator=integrator
    )
    # Without an oscillator the frequency has no effect, but must be a number.
    driven = scenario._replace(omega=np.nan_to_num(scenario.omega))
    trajectory = engine.run(weights, driven, body)
    if protocol.drop_m == 0.0:
        return trajectory, None
    drop_time_s = np.asarray(_next_apex_s(trajectory, body.rest_length_m, protocol.undisturbed_s))
    driven = driven._replace(drop_m=protocol.drop_m, drop_time_s=drop_time_s)
    return engine.run(weights, driven, body), drop_time_s


@jax.jit
def _next_apex_s(trajectory: Trajectory, rest_length_m: Numeric, after_s: Numeric) -> jax.Array:
    """Time of the apex of the first hop after a time [s], [lanes]; infinite if there is none."""
    time_s = hops(trajectory, rest_length_m).time_s
    return jnp.min(jnp.where(time_s >= after_s, time_s, jnp.inf), axis=0)


def _of_clamped(
    controller: Controller,
    weights: np.ndarray,
    scenario: Scenario,
    body: Body,
    protocol: Protocol,
    integrator: Integrator,
    metrics: Sequence[ClampedMetric],
) -> dict[str, np.ndarray]:
    """Metrics of every lane's rollouts with a clamped phase, [lanes] each by name.

    Undefined without an oscillator to clamp.
    """
    if controller.oscillator is None:
        return {metric.name: np.full(len(weights), np.nan) for metric in metrics}
    episodes = clamped_rollouts(controller, weights, scenario, body, protocol, integrator)
    return {metric.name: np.asarray(metric.compute(episodes), float) for metric in metrics}


def clamped_rollouts(
    controller: Controller,
    weights: np.ndarray,
    scenario: Scenario,
    body: Body,
    protocol: Protocol,
    integrator: Integrator = CONTINUOUS,
) -> ClampedEpisodes:
    """Undisturbed episodes with the oscillator clamped to each of the protocol's phases.

    Args:
        controller: what drives the body; it has an oscillator.
        weights: shape [lanes, n_weights].
        scenario: frequencies ω [rad/s] and heights of the release, [lanes].
        body: the body.
        protocol: how many phases, time, control period, what counts as settled.
        integrator: how controller and body advance by a control period.
    """
    assert controller.oscillator is not None
    engine = Engine(
        controller=dataclasses.replace(controller, oscillator=Clamped(controller.oscillator)),
        timing=Timing(duration_s=protocol.undisturbed_s, tick_s=protocol.tick_s),
        summary=_hops_and_end,
        integrator=integrator,
    )
    n = protocol.clamped_phases
    phases = 2.0 * np.pi * np.arange(n) / n
    clamped = scenario._replace(
        omega=np.repeat(scenario.omega, n),
        height_m=np.repeat(scenario.height_m, n),
        phase_rad=np.tile(phases, len(weights)),
    )
    table, end_s, failed = engine.run(np.repeat(weights, n, axis=0), clamped, body)
    cycle = _settled(table, protocol.limit_cycle, -np.inf, end_s)
    by_phase = (np.asarray(value).reshape(-1, n) for value in cycle)
    return ClampedEpisodes(phases, Settled(*by_phase), np.asarray(failed).reshape(-1, n))


def _hops_and_end(
    trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
) -> tuple[Hops, jax.Array, jax.Array]:
    """The table of hops, the time of the end [s] and who had failed by then, as a summary."""
    return hops(trajectory, body.rest_length_m), trajectory.time_s[-1], trajectory.failed[-1]


# Apart from the rollout, which is thus not compiled anew for other tolerances.
_settled = jax.jit(settled, static_argnames="settings")


def _checked_weights(controller: Controller, weights: ArrayLike) -> np.ndarray:
    try:
        rows = np.atleast_2d(np.asarray(weights, float))
    except (TypeError, ValueError):
        raise TegotaeError("weights are no array of numbers") from None
    if rows.ndim != 2 or len(rows) == 0 or rows.shape[1] != controller.n_weights:
        raise TegotaeError(
            f"weights have shape {np.shape(weights)}; this controller needs "
            f"[runs, {controller.n_weights}]"
        )
    if not np.isfinite(rows).all():
        run = int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise TegotaeError(f"the weights of run {run} are not all finite; leave that run out")
    return rows
