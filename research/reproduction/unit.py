"""One unit of the study's work: all seeds of one model, trained and evaluated."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from research.reproduction import best_gait
from research.reproduction.record import Record
from tegotae import study
from tegotae._support.documents import CODE, Document
from tegotae._support.errors import TegotaeError, require_count
from tegotae.measures.evaluation import evaluate, require_evaluable
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.metric import Metric
from tegotae.simulation.world import Scenario
from tegotae.study import CellResult
from tegotae.systems.experiment import Experiment
from tegotae.systems.registry import code_noted, parts_in, register
from tegotae.training.evolution import SEARCH, Curves, Evolution
from tegotae.training.run import Run
from tegotae.training.scoring import best_gain

FORMAT = 4
"""Changed whenever the same configuration would give other numbers."""


@dataclass(frozen=True)
class Unit:
    """A training, and the budgets after which it is evaluated.

    Args:
        run: the training; its experiment says how is evaluated, too.
        budgets: after how many episodes of training it is evaluated, too.
        metrics: a user's metrics by which it is evaluated beside the package's; each is measured,
            as those that follow from others are computed from a record when they are asked for.

    Raises:
        TegotaeError: for budgets that are not in rising order.
    """

    run: Run[Evolution]
    budgets: tuple[int, ...] = ()
    metrics: tuple[Metric, ...] = ()

    def __post_init__(self) -> None:
        for budget in self.budgets:
            require_count("budget", budget)
        if any(a >= b for a, b in pairwise(self.budgets)):
            raise TegotaeError(f"budgets are {self.budgets}; each must be larger than the last")

    @property
    def configuration(self) -> Document:
        """All settings that determine the record's content, as JSON values."""
        document = {
            "format": FORMAT,
            **self.run.configuration,
            "stopping": dataclasses.asdict(self.run.learner.stopping),
            "budgets": list(self.budgets),
            **metrics_document(self.metrics),
        }
        return json.loads(json.dumps(document))

    @property
    def name(self) -> str:
        """Name of the experiment."""
        return self.run.experiment.name

    @property
    def document(self) -> Document:
        """All settings that determine the record's content (`configuration`)."""
        return self.configuration

    @property
    def program(self) -> Hashable:
        """Units of an equal value share a compiled program."""
        return self.run.learner.program(self.run.experiment)

    def prepare(self) -> None:
        """Register a user's parts."""
        for part in (*parts_in((self.run.experiment, self.run.learner.algorithm)), *self.metrics):
            register(part)

    def measure(self) -> CellResult:
        """Train and evaluate."""
        return work(self).result

    @property
    def key(self) -> str:
        """The record's name: the experiment's, and a hash of the configuration."""
        return record_key(self.configuration)


def metrics_document(metrics: Iterable[Metric]) -> Document:
    """Return the descriptions of a user's metrics, names and code; empty for none."""
    documents = {}
    for metric in metrics:
        code = code_noted(metric)
        documents[metric.name] = {"name": metric.name} | ({} if code is None else {CODE: code})
    return {"metrics": documents} if documents else {}


def record_key(configuration: Document) -> str:
    """Return the name of a record with this configuration: the experiment's, and a hash of it
    all.
    """
    return study.cell_key(configuration["experiment"]["name"], configuration)


class _Learned(NamedTuple):
    """Result of a training, and its states at some budgets on the way."""

    weights: np.ndarray
    """Means of the best distributions seen, shape [runs, n_weights]."""
    deviation: np.ndarray
    """Standard deviations of these distributions, shape [runs, n_weights]."""
    fitness: np.ndarray
    """[runs]."""
    generations: np.ndarray
    """Number of generations of each run, [runs]."""
    ended: list[str]
    """Reason of each run's end."""
    curves: list[Curves]
    """Generation by generation."""
    at_budgets: list[np.ndarray]
    """The weights at each of the unit's budgets, [runs, n_weights]."""


def drawn_start(standard: Scenario, runs: int, spread_m: float = 0.1) -> Scenario:
    """Return the standard release at phase 0, and others drawn around it: entries of shape [runs].

    A search has no randomness. What spreads are the conditions that its outcome starts from.

    Args:
        standard: the release.
        runs: how many in all.
        spread_m: how far the others are above or below it at most [m]; their phases are anywhere.
    """
    draw = np.random.default_rng(0)
    height = standard.height_m + draw.uniform(-spread_m, spread_m, runs)
    phase = draw.uniform(0.0, 2.0 * np.pi, runs)
    height[0], phase[0] = standard.height_m, 0.0
    return standard._replace(height_m=height, phase_rad=phase)


def work(unit: Unit) -> Record:
    """Train a unit from random weights and evaluate the result. The work is deterministic."""
    run, experiment = unit.run, unit.run.experiment
    assert isinstance(experiment, Experiment)  # studies are of the engine
    system, n_runs = experiment.system, len(run.seeds)
    protocol = system.evaluated_by(experiment.protocol)
    require_evaluable(experiment.controller, experiment.body, protocol)
    learned = _searched(run) if experiment.is_searched else _trained(unit)
    drawn = [_draw_controllers(learned, run.seeds)] if learned.deviation.any() else []
    sets = np.concatenate([learned.weights, *learned.at_budgets, *drawn])
    evaluation = evaluate(
        experiment.controller,
        sets,
        experiment.omega,
        experiment.body,
        protocol,
        (*HOPPING.built_in, *unit.metrics),
        best_gait.CHANNELS,
        start=drawn_start(system.scenario(), n_runs)
        if experiment.is_searched
        else system.scenario(),
        integrator=system.integrator,
    )

    def episodes_at(number: int) -> dict[str, np.ndarray]:
        rows = slice(number * n_runs, (number + 1) * n_runs)
        return {
            name: values[rows].astype("float32") for name, values in evaluation.episodes.items()
        }

    budgets = range(1, 1 + len(learned.at_budgets))
    of_drawn = 1 + len(learned.at_budgets) if drawn else 0
    return Record(
        configuration=unit.configuration,
        software=run.software,
        weights=learned.weights.astype("float32"),
        deviation=learned.deviation.astype("float32"),
        best_fitness=learned.fitness.astype("float32"),
        generations=learned.generations,
        ended=np.array(learned.ended),
        curves={
            name: np.stack([getattr(c, name) for c in learned.curves]).astype("float32")
            for name in Curves._fields
            if learned.curves
        },
        omega=evaluation.omega,
        episodes=episodes_at(0),
        at_budgets={
            name: np.stack([episodes_at(number)[name] for number in budgets])
            for name in evaluation.episodes
            if budgets
        },
        sampled=episodes_at(of_drawn),
        gait=best_gait.gait_channels(evaluation, learned.fitness, experiment.omega),
    )


def _draw_controllers(learned: _Learned, seeds: Iterable[int]) -> np.ndarray:
    """Draw a controller of each run from the best distribution that it saw, [runs, n_weights]."""
    normal = [
        np.random.default_rng(seed).standard_normal(learned.weights.shape[1]) for seed in seeds
    ]
    return (learned.weights + learned.deviation * np.stack(normal)).astype(learned.weights.dtype)


def _trained(unit: Unit) -> _Learned:
    run = unit.run
    budgets = [math.ceil(episodes / run.learner.algorithm.population) for episodes in unit.budgets]
    curves: list[Curves] = []
    snapshots: list[np.ndarray] = []
    progress = begun = run.learner.start(run.experiment, run.seeds)
    for progress, generation in run.learner.evolve(run.experiment, run.seeds, begun):
        curves.append(generation)
        while len(snapshots) < len(budgets) and len(curves) == budgets[len(snapshots)]:
            snapshots.append(np.asarray(progress.best_weights))
    weights = np.asarray(progress.best_weights)
    # A training that ended before a budget is at that budget what it ended in.
    snapshots += [weights] * (len(budgets) - len(snapshots))
    return _Learned(
        weights,
        np.asarray(progress.best_std),
        np.asarray(progress.best_fitness),
        np.asarray(progress.generation),
        run.learner.stopping.reasons(np.array([curve.centre_fitness for curve in curves])),
        curves,
        snapshots,
    )


def _searched(run: Run[Evolution]) -> _Learned:
    gain, fitness = best_gain(run.experiment)
    n = len(run.seeds)
    return _Learned(
        np.full((n, 1), gain),
        np.zeros((n, 1)),
        np.full(n, fitness),
        np.zeros(n, int),
        [SEARCH] * n,
        [],
        [],
    )
