"""The paper's evaluation of trained or hand-made controllers: five frequencies, a drop, a clamp."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M, MOST_POINTS, MOST_RAD_PER_S
from tegotae._support.transforms import jit_in_one_module
from tegotae.measures.hopping.gait import gait
from tegotae.measures.hopping.hopping import Hops, LimitCycle, Settled, find_limit_cycle, hops
from tegotae.measures.hopping.metrics import (
    HOPPING,
    ClampedEpisodes,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
    built_in_gait,
    channels_of,
    with_needed,
)
from tegotae.measures.hopping.signals import check_work, require_measurable
from tegotae.measures.metric import Metric
from tegotae.measures.statistics import Interval, interval, mean_defined
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body, Hopper, require_one_limb
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import Clamped
from tegotae.parts.parameters import Part, finite, whole
from tegotae.simulation.checks.passive import check_passive
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Rollout, Scenario, Timing, as_lanes, check_senses
from tegotae.simulation.summaries import KeptChannels, Summary

CONTINUOUS = PredictorCorrector()
"""Time as the paper has it: the controller is not held over a control period."""
ACCURACY = 0.01
"""Largest relative error of a metric that is resolved by the control period."""


@dataclass(frozen=True, kw_only=True)
class Protocol(Part):
    """Conditions of an evaluation.

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
    undisturbed_s: float = finite(40.0, least=1.0)
    disturbed_s: float = finite(40.0, least=1.0)
    drop_m: float = finite(0.2, least=0.0, most=MOST_M)
    clamped_phases: int = whole(6, most=MOST_POINTS)
    limit_cycle: LimitCycle = field(default_factory=LimitCycle)
    work: str = "absolute"
    tick_s: float = 0.001
    release_m: float = finite(1.2, above=0.0, most=MOST_M)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.offsets:
            raise TegotaeError("offsets is empty; give at least one, such as 0")
        for offset in self.offsets:
            require_finite("an offset of the frequency", offset)
        check_work(self.work)

    def omegas(self, controller: Controller, omega_t: float | None) -> tuple[float, ...]:
        """Return the frequencies of the episodes [rad/s]; a single NaN without an oscillator.

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


@dataclass(frozen=True)
class Evaluation:
    """Results of an evaluation, episode by episode. NaN is undefined everywhere.

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

    def runs(self) -> dict[str, np.ndarray]:
        """Return the metrics of every run, shape [runs]: means over its episodes.

        Episodes in which a metric is undefined do not enter its mean; `limit_cycle_share`,
        `recovery_share` and `failed_share` say how many those are. A metric that no episode
        defines is NaN.
        """
        return {name: mean_defined(values) for name, values in self.episodes.items()}

    def resolved(self, finer: Evaluation) -> np.ndarray:
        """Return which episodes half the control period leaves as they are, [runs, episodes].

        Of every metric of the finer evaluation both values are undefined, or half the period
        changes it by at most 0.5 %. Where halving at least halves the error, that is at most 1 %.

        Args:
            finer: the same runs at half the control period, with some of the metrics.

        Example:
            >>> from tegotae.systems.recipe import recipe
            >>> controller, metrics = recipe("V-reflex-w8").controller(), ["cot_inverse"]
            >>> coarse, fine = (
            ...     evaluate(controller, [2.0], 8.0, protocol=Protocol(tick_s=x), metrics=metrics)
            ...     for x in (0.002, 0.001)
            ... )
            >>> coarse.resolved(fine).tolist()
            [[True, True, True, True, True]]
        """
        close = [
            np.isclose(self.episodes[name], values, rtol=0.5 * ACCURACY, atol=0.0, equal_nan=True)
            for name, values in finer.episodes.items()
        ]
        return np.all(close, axis=0)

    def summary(self) -> dict[str, Interval]:
        """Return the mean over runs of each metric, with its spread and 95 % interval within
        its range.
        """
        ranges = {name: HOPPING.range_of(name) for name in self.episodes}
        return {name: interval(x, within=ranges[name]) for name, x in self.runs().items()}


def evaluate(
    controller: Controller,
    weights: ArrayLike,
    omega_t: float | None,
    body: Body | None = None,
    protocol: Protocol | None = None,
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
        metrics: names of the metrics that are asked for; all that there are by default.
        recorded: names of channels whose undisturbed part is returned, too; none by default.
        start: the release, of which height and phase may be of shape [runs]; at rest and at phase 0
            from the protocol's height by default.
        integrator: how controller and body advance by a control period; in continuous time by
            default.

    Raises:
        TegotaeError: for weights of the wrong shape or not finite, a missing or non-positive
            frequency, a metric or channel that is not there, or what `require_evaluable` refuses.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> model = recipe("V-reflex-w8")
        >>> result = evaluate(
        ...     model.controller(), [[2.0]], model.omega_t, metrics=["cot_inverse"]
        ... )
        >>> f"{result.summary()['cot_inverse'].mean:.2f} m/J"
        '0.44 m/J'
    """
    body, protocol, selected = body or Hopper(), protocol or Protocol(), HOPPING.select(metrics)
    require_evaluable(controller, body, protocol)
    omegas = np.array(protocol.omegas(controller, omega_t))
    rows = as_lanes(controller, body, weights, Scenario(0.0), "float64").weights.T
    sound = np.isfinite(rows).all(axis=1)
    if not len(rows) or not sound.all():
        raise TegotaeError(
            f"weights must be finite, of one run or more; those of {(~sound).sum()} of {len(rows)} "
            "runs are not"
        )
    runs, n_omegas = len(rows), len(omegas)
    start = Scenario(0.0, height_m=protocol.release_m) if start is None else start

    def of_lanes(of_runs: ArrayLike) -> np.ndarray:
        return np.repeat(np.broadcast_to(of_runs, runs), n_omegas)

    episodes = EvaluatedEpisodes(
        controller,
        np.repeat(rows, n_omegas, axis=0),
        start._replace(
            omega=np.tile(omegas, runs),
            height_m=of_lanes(start.height_m),
            phase_rad=of_lanes(start.phase_rad),
        ),
        body,
        protocol,
        CONTINUOUS if integrator is None else integrator,
    )
    needed = with_needed(selected)
    values: dict[str, np.ndarray] = {}
    recording: dict[str, np.ndarray] = {}
    if recorded or not all(isinstance(metric, ClampedMetric) for metric in needed):
        of_gait = [metric for metric in needed if isinstance(metric, GaitMetric)]
        values, recording = episodes.measured(of_gait, recorded)
    if of_clamped := [metric for metric in needed if isinstance(metric, ClampedMetric)]:
        values |= episodes.clamped_metrics(of_clamped)
    conditions = Conditions(body, protocol.work, protocol.drop_m)
    for metric in needed:
        if isinstance(metric, DerivedMetric):
            values[metric.name] = metric.values(values, conditions)
    return Evaluation(
        protocol,
        omegas,
        {m.name: _per_lane(m, values[m.name], runs * n_omegas).reshape(runs, -1) for m in selected},
        {name: value.reshape(-1, runs, n_omegas) for name, value in recording.items()},
    )


def require_evaluable(controller: Controller, body: Body, protocol: Protocol) -> None:
    """Raise `TegotaeError` if a controller on a body cannot be evaluated: before long work starts.

    That is: if they do not go together, the control period is too long for the body or no part of
    20 ms, the body has several limbs, whose gaits have metrics of their own, or a body of a user's
    own climbs without work (`check_passive`).

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
    check_passive(body, protocol.release_m, protocol.undisturbed_s, protocol.tick_s)


def _per_lane(metric: Metric, values: np.ndarray, lanes: int) -> np.ndarray:
    if np.shape(values) != (lanes,):
        raise TegotaeError(
            f"the metric {metric.name} gave an array of shape {np.shape(values)} for {lanes} "
            "lanes; it must give one number a lane (tegotae.check tries it)"
        )
    return values


@dataclass(frozen=True)
class EvaluatedEpisodes:
    """Episodes of an evaluation, a lane each.

    Args:
        controller: what drives the body.
        weights: shape [lanes, n_weights].
        scenario: frequencies ω [rad/s], NaN without an oscillator, and releases.
        body: the body.
        protocol: times, size of the drop, clamped phases, control period, what counts as settled.
        integrator: how controller and body advance by a control period.
    """

    controller: Controller
    weights: np.ndarray
    scenario: Scenario
    body: Body
    protocol: Protocol
    integrator: Integrator = CONTINUOUS

    def rolled_out(self, duration_s: float, summary: Summary, **changed: ArrayLike) -> Any:
        """Simulate episodes of a duration [s], with other values for some entries of the
        scenario.
        """
        timing = Timing(duration_s=duration_s, tick_s=self.protocol.tick_s)
        rollout = Rollout(
            controller=self.controller, timing=timing, summary=summary, integrator=self.integrator
        )
        # Without an oscillator the frequency has no effect, but must be a number.
        omega = np.nan_to_num(self.scenario.omega)
        scenario = self.scenario._replace(**{"omega": omega, **changed})
        return rollout.run(self.weights, scenario, self.body)

    def undisturbed(self, channels: tuple[str, ...] | None = None) -> Trajectory:
        """Return the undisturbed part alone, with some channels or all."""
        return self.rolled_out(self.protocol.undisturbed_s, KeptChannels(channels))

    def disturbed(
        self, channels: tuple[str, ...] | None = None
    ) -> tuple[Trajectory, np.ndarray | None]:
        """Simulate episodes in which the ground drops at the first apex of a hop after the
        undisturbed time.

        Where that apex lies is known only from a rollout, so each episode is rolled out twice:
        without the drop, and with it.

        Args:
            channels: which are recorded; all by default.

        Returns:
            The trajectory, arrays of shape [frames, lanes], and when the ground dropped [s],
            [lanes]: infinite in lanes that hop no more, None if the protocol has no drop.
        """
        protocol, body = self.protocol, self.body
        duration_s = protocol.undisturbed_s + protocol.disturbed_s
        trajectory = self.rolled_out(duration_s, KeptChannels(channels))
        if protocol.drop_m == 0.0:
            return trajectory, None
        apex_s = np.asarray(_next_apex_s(trajectory, body.rest_length_m, protocol.undisturbed_s))
        dropped = {"drop_m": protocol.drop_m, "drop_time_s": apex_s}
        return self.rolled_out(duration_s, KeptChannels(channels), **dropped), apex_s

    def clamped(self) -> ClampedEpisodes:
        """Simulate undisturbed episodes with the oscillator clamped to each of the protocol's
        phases.
        """
        assert self.controller.oscillator is not None
        n = self.protocol.clamped_phases
        phases, scenario = 2.0 * np.pi * np.arange(n) / n, self.scenario
        still = dataclasses.replace(
            self,
            controller=dataclasses.replace(
                self.controller, oscillator=Clamped(self.controller.oscillator)
            ),
            weights=np.repeat(self.weights, n, axis=0),
            scenario=scenario._replace(
                omega=np.repeat(scenario.omega, n),
                height_m=np.repeat(scenario.height_m, n),
                phase_rad=np.tile(phases, len(self.weights)),
            ),
        )
        table, end_s, failed = still.rolled_out(self.protocol.undisturbed_s, _hops_and_end)
        cycle = _settled(table, self.protocol.limit_cycle, -np.inf, end_s)
        by_phase = (np.asarray(value).reshape(-1, n) for value in cycle)
        return ClampedEpisodes(phases, Settled(*by_phase), np.asarray(failed).reshape(-1, n))

    def measured(
        self, metrics: Sequence[GaitMetric], recorded: Sequence[str]
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Measure every lane's recording: metrics, [lanes] each by name, and the regime; some
        channels.

        The channels are those of the undisturbed part, [frames, lanes]. Where a metric is about it,
        the ground drops at the first apex after that.
        """
        gait_metrics, protocol = built_in_gait(), self.protocol
        channels = tuple(dict.fromkeys((*channels_of((*gait_metrics, *metrics)), *recorded)))
        if any(metric.disturbed for metric in metrics):
            trajectory, drop_time_s = self.disturbed(channels)
        else:
            trajectory, drop_time_s = self.undisturbed(channels), None
        # The package's own are always computed together, by one program, whatever else is asked
        # for: their numbers do not depend on which others there are.
        users = tuple(metric for metric in metrics if metric not in gait_metrics)
        values: dict[str, np.ndarray] = {}
        for together in (gait_metrics, users) if users else (gait_metrics,):
            of_gait = gait(
                trajectory,
                omega=jnp.asarray(self.scenario.omega, "float32"),
                rest_length_m=self.body.rest_length_m,
                max_force_n=self.body.max_force_n,
                frame_s=Timing().frame_s,
                undisturbed_s=protocol.undisturbed_s,
                disturbed_at_s=drop_time_s,
                limit_cycle=protocol.limit_cycle,
                work=protocol.work,
                has_oscillator=self.controller.oscillator is not None,
                metrics=together,
            )
            values |= {name: np.asarray(value, float) for name, value in of_gait.values.items()}
        undisturbed = slice(round(protocol.undisturbed_s / Timing().frame_s))
        return values, {name: getattr(trajectory, name)[undisturbed] for name in recorded}

    def clamped_metrics(self, metrics: Sequence[ClampedMetric]) -> dict[str, np.ndarray]:
        """Measure rollouts with a clamped phase, [lanes] each by name; undefined without an
        oscillator.
        """
        if self.controller.oscillator is None:
            return {metric.name: np.full(len(self.weights), np.nan) for metric in metrics}
        episodes = self.clamped()
        return {metric.name: np.asarray(metric.compute(episodes), float) for metric in metrics}


@jit_in_one_module
def _next_apex_s(trajectory: Trajectory, rest_length_m: Numeric, after_s: Numeric) -> jax.Array:
    """Return the time of the apex of the first hop after a time [s], [lanes]; infinite if there
    is none.
    """
    time_s = hops(trajectory, rest_length_m).time_s
    return jnp.min(jnp.where(time_s >= after_s, time_s, jnp.inf), axis=0)


def _hops_and_end(
    trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
) -> tuple[Hops, jax.Array, jax.Array]:
    """Return the table of hops, the time of the end [s] and the failures by then, as a summary."""
    return hops(trajectory, body.rest_length_m), trajectory.time_s[-1], trajectory.failed[-1]


# Apart from the rollout, which is thus not compiled anew for other tolerances.
_settled = jit_in_one_module(find_limit_cycle, static_names=("settings",))
