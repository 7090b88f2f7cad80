"""Trained runs judged from common releases: whole, with the feedback cut, and with it frozen."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from research.reproduction.record import Record
from research.reproduction.unit import record_key
from tegotae._support.documents import Document
from tegotae.measures.evaluation import Evaluation, Protocol, evaluate
from tegotae.measures.hopping.metrics import HOPPING, Episode, GaitMetric
from tegotae.measures.metric import Metric
from tegotae.measures.statistics import UNBOUNDED, mean_defined
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace
from tegotae.parts.held import with_held_feedback
from tegotae.simulation.world import Scenario
from tegotae.study import Arrays, CellResult
from tegotae.systems.experiment import Experiment
from tegotae.systems.registry import register

VARIANTS = ("whole", "cut", "frozen")
"""The feedback as it is, at zero, and at its mean over the limit cycle."""
RELEASES = 15
"""Common releases from which every run is judged."""
SPREAD_M = 0.1
"""Largest distance of a release from the training's height [m]."""
_SEED = 36


@GaitMetric.described(
    label="mean f",
    unit="rad/s",
    more_is_better=None,
    range=UNBOUNDED,
    channels=("feedback_rad_per_s",),
    shown=(),
)
def mean_feedback(episode: Episode) -> jax.Array:
    """mean feedback over the settled part"""
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    return episode.where_settled(episode.mean_where(feedback, True))


MEASURED = ("limit_cycle_share", "cot_inverse", "hop_rate")
"""Metrics of every episode, by name."""


def releases(standard: Scenario) -> Scenario:
    """Return the common releases: entries of shape [`RELEASES`], the same for all models of a body.

    Heights are uniform within `SPREAD_M` of the training's release, phases anywhere. No training
    and no search saw them.
    """
    draw = np.random.default_rng(_SEED)
    height = standard.height_m + draw.uniform(-SPREAD_M, SPREAD_M, RELEASES)
    return standard._replace(height_m=height, phase_rad=draw.uniform(0.0, 2.0 * np.pi, RELEASES))


def judge_runs(experiment: Experiment, weights: np.ndarray, *, whole_alone: bool = False) -> Arrays:
    """Judge runs from the common releases at every frequency of the evaluation.

    Args:
        experiment: what was trained.
        weights: of its runs, [runs, n_weights].
        whole_alone: leave out the other variants.

    Returns:
        `MEASURED` by name, each of shape [`VARIANTS`, runs, releases, ω], NaN where undefined; and
        `mean_feedback` [rad/s], [runs, ω], over the releases that settle. One network has no
        feedback, and its entries of the other variants are NaN. A run that nowhere settles at a
        frequency is frozen at zero there.
    """
    register(mean_feedback)
    try:
        return _variants(experiment, weights, whole_alone)
    finally:  # a study that is planned later is not to have it
        HOPPING.forget(mean_feedback.name)


def _variants(experiment: Experiment, weights: np.ndarray, whole_alone: bool) -> Arrays:
    metrics = (*MEASURED, mean_feedback)
    complete = episodes_of(experiment, experiment.controller, weights, experiment.protocol, metrics)
    feedback = mean_defined(np.moveaxis(by_release(complete, mean_feedback.name), 1, -1))
    variants = [complete]
    if experiment.controller.tegotae is not None and not whole_alone:
        clock, cut = with_held_feedback(experiment.controller, weights)
        variants.append(episodes_of(experiment, clock, cut, experiment.protocol))
        variants.append(_frozen(experiment, weights, np.nan_to_num(feedback)))
    arrays = {"mean_feedback": feedback.astype("float32")}
    for name in MEASURED:
        values = np.full(
            (1 if whole_alone else len(VARIANTS), *by_release(complete, name).shape),
            np.nan,
            "float32",
        )
        for i, variant in enumerate(variants):
            values[i] = by_release(variant, name)
        arrays[name] = values
    return arrays


def _frozen(experiment: Experiment, weights: np.ndarray, feedback: np.ndarray) -> Evaluation:
    """Return every frequency with its own constant feedback, [runs, ω]."""
    alone = []
    for i, offset in enumerate(experiment.protocol.offsets):
        clock, frozen = with_held_feedback(experiment.controller, weights, feedback[:, i])
        protocol = dataclasses.replace(experiment.protocol, offsets=(offset,))
        alone.append(episodes_of(experiment, clock, frozen, protocol))
    episodes = {
        name: np.concatenate([evaluation.episodes[name] for evaluation in alone], axis=1)
        for name in MEASURED
    }
    return dataclasses.replace(alone[0], episodes=episodes)


def episode_merits(settled: np.ndarray, cot_inverse: np.ndarray) -> np.ndarray:
    """Return CoT⁻¹ of every episode [m/J], 0 for one that does not settle, NaN for a missing
    one.
    """
    unsettled = np.where(np.isnan(settled), np.nan, 0.0)
    return np.where(settled == 1.0, np.nan_to_num(cot_inverse), unsettled)


def episodes_of(
    experiment: Experiment,
    controller: Controller,
    weights: np.ndarray,
    protocol: Protocol,
    metrics: Sequence[str | Metric] = MEASURED,
) -> Evaluation:
    """Return every run from every release, the releases of a run adjacent."""
    start = releases(experiment.system.scenario())
    return evaluate(
        controller,
        np.repeat(weights, RELEASES, axis=0),
        experiment.omega,
        experiment.body,
        experiment.system.evaluated_by(protocol),
        metrics,
        start=start._replace(
            height_m=np.tile(start.height_m, len(weights)),
            phase_rad=np.tile(start.phase_rad, len(weights)),
        ),
        integrator=experiment.system.integrator,
    )


def by_release(evaluation: Evaluation, name: str) -> np.ndarray:
    """Return a metric, [runs, releases, ω]."""
    values = evaluation.episodes[name]
    return values.reshape(-1, RELEASES, values.shape[-1])


@dataclass(frozen=True)
class EvaluatedRuns:
    """All runs of one record, as a cell of a study (`tegotae.study.Study`).

    Args:
        record: what was trained.
        undisturbed_s: duration of an episode [s]; None for that of the study's evaluation.
        tick_s: control period [s], likewise.
    """

    record: Record
    undisturbed_s: float | None = None
    tick_s: float | None = None

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.record.model

    @property
    def document(self) -> Document:
        """The record, and the settings of its evaluation."""
        name = record_key(self.record.configuration)
        settings = {"record": name, "releases": RELEASES, "spread_m": SPREAD_M, "seed": _SEED}
        return settings | self._changed

    @property
    def _changed(self) -> dict[str, float]:
        times = {"undisturbed_s": self.undisturbed_s, "tick_s": self.tick_s}
        return {name: value for name, value in times.items() if value is not None}

    @property
    def program(self) -> Hashable:
        """Records of one controller share compiled programs."""
        return repr(self.record.experiment.controller)

    def prepare(self) -> None:
        """Prepare nothing: the package has all that it needs."""

    def measure(self) -> CellResult:
        """Judge them; a search has one run."""
        experiment, record = self.record.experiment, self.record
        protocol = dataclasses.replace(experiment.protocol, **self._changed)
        experiment = replace(experiment, {"protocol": protocol})
        weights = record.weights[:1] if experiment.is_searched else record.weights
        return CellResult(self.document, record.software, judge_runs(experiment, weights))
