"""An agent that learns: SAC, PPO, one seed after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.engines import XLA
from tegotae._support.errors import TegotaeError, require_count
from tegotae.parts.bodies import require_one_limb
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.systems.descriptions import check_kept
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import Release
from tegotae.training.agents.settings import AgentSettings, SACSettings, agent_controller
from tegotae.training.algorithms.document import algorithm_document
from tegotae.training.evaluator import evaluator_of
from tegotae.training.folder import versions_of
from tegotae.training.learner import (
    CurvePoint,
    LearnedController,
    Learner,
    LearningStep,
    Session,
    Trainable,
)

if TYPE_CHECKING:
    from tegotae.training.agents.learning import AgentTask, Point


@dataclass(frozen=True, kw_only=True)
class AgentLearner(Learner):
    """Learning by an agent, one seed after the other; resumable by seed.

    On the engine an agent's reward has no ΔΩ, and so its policies are evaluated without it; the
    experiment's control period is that of the evaluations. On an environment policies are evaluated
    by the experiment's objective, as those of a population.

    Args:
        settings: the algorithm and how it is set.
        episodes: how long each seed learns, in simulated time of so many whole episodes.
        evaluate_every: episodes between two points of the learning curve.

    Raises:
        TegotaeError: for a count below one.
    """

    settings: AgentSettings = field(default_factory=SACSettings)
    episodes: int = 1000
    evaluate_every: int = 10

    UNIT = "episode"

    def __post_init__(self) -> None:
        require_count("episodes", self.episodes)
        require_count("evaluate_every", self.evaluate_every)

    @property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""
        return versions_of("stable-baselines3", "torch", "gymnasium")

    def engine(self, experiment: Trainable) -> str:
        """XLA's: an agent acts within every episode, tick by tick."""
        if isinstance(experiment, Experiment):
            return XLA
        with evaluator_of(experiment) as evaluator:
            return evaluator.engine

    def check(self, experiment: Trainable) -> None:
        """Raise `TegotaeError` for what an agent cannot learn.

        That is a controller without a meaning for agents; on the engine also a body of several
        limbs, conditions that change, an integrator or a release of its own.
        """
        if isinstance(experiment, Experiment):
            _check_on_engine(experiment)
        _ = self.controller(experiment)

    def controller(self, experiment: Trainable) -> Controller:
        """The policy."""
        return agent_controller(experiment, self.settings)

    def configuration(self, experiment: Trainable, seeds: tuple[int, ...]) -> JsonObject:
        """What decides a seed's result, but for the number of episodes, as JSON values."""
        own = experiment
        if isinstance(own, Experiment):
            own = own.replaced(objective=own.objective.without_frequency())
        return {
            "experiment": own.document,
            "algorithm": algorithm_document(self.settings),
            "evaluate_every": self.evaluate_every,
        }

    def session(self, experiment: Trainable, seeds: tuple[int, ...]) -> Session:
        """The learning of an experiment.

        Raises:
            MissingExtraError: without Stable-Baselines3.
        """
        check_kept(self.settings)
        return AgentSession(self, _task_of(experiment, self.settings), seeds)


def _task_of(experiment: Any, settings: AgentSettings) -> AgentTask:
    """What the agent learns in."""
    if isinstance(experiment, Experiment):
        from tegotae.training.agents.learning import AgentTraining

        return AgentTraining(experiment, settings)
    from tegotae.training.agents.on_environment import EnvAgentTraining

    return EnvAgentTraining(experiment, settings)


def _check_on_engine(experiment: Experiment) -> None:
    """Raise `TegotaeError` for what differs between episodes, or from what the hopper offers."""
    require_one_limb(experiment.body, "learning by agents")
    release = experiment.system.release
    if release != Release(height_m=release.height_m):
        raise TegotaeError("agents learn from releases at rest and phase 0; give height_m alone")
    if experiment.conditions:
        raise TegotaeError(
            "agents learn in the same episode again and again; leave the experiment's "
            "conditions, which a population can have (pgpe)"
        )
    if experiment.system.integrator != PredictorCorrector():
        raise TegotaeError(
            "agents learn in continuous time; leave the experiment's integrator, which a "
            "population can have (pgpe)"
        )


@dataclass(frozen=True, eq=False)
class _Course:
    """What a seed has learned until here."""

    points: tuple[CurvePoint, ...]
    best: CurvePoint
    weights: np.ndarray
    """Of the best point, shape [n_weights]."""

    def then(self, point: CurvePoint, weights: np.ndarray) -> _Course:
        """The same with another point."""
        points = (*self.points, point)
        if point.fitness > self.best.fitness:
            return _Course(points, point, weights)
        return _Course(points, self.best, self.weights)


class AgentSession(Session):
    """Seeds, one after the other.

    Args:
        learner: how is learned.
        training: the experiment as an agent learns it.
        seeds: one training from random weights each.
    """

    def __init__(self, learner: AgentLearner, training: AgentTask, seeds: tuple[int, ...]) -> None:
        self._learner, self._training, self._seeds = learner, training, seeds
        self._courses: dict[int, _Course] = {}

    @property
    def length(self) -> int:
        """Episodes of all seeds."""
        return len(self._seeds) * self._learner.episodes

    def steps(self) -> Iterator[LearningStep]:
        """A point of a seed's learning curve each; seeds that are done are left as they are."""
        from tegotae.training.agents.learning import learn

        episodes, every = self._learner.episodes, self._learner.evaluate_every
        for i, seed in enumerate(self._seeds):
            if self._is_done(seed):
                continue
            self._courses.pop(seed, None)
            for found in learn(self._training, seed=seed, episodes=episodes, evaluate_every=every):
                point = CurvePoint(
                    seed, found.episode, found.simulated_s, found.fitness, found.cot_inverse
                )
                so_far = self._courses.get(seed) or _Course((), point, found.weights)
                self._courses[seed] = so_far.then(point, found.weights)
                done = i * episodes + min(round(found.episode), episodes)
                yield LearningStep(done, f"seed {seed}  {_report(found)}", (point,))

    def _is_done(self, seed: int) -> bool:
        course = self._courses.get(seed)
        return course is not None and course.points[-1].step >= self._learner.episodes

    def points(self) -> list[CurvePoint]:
        """The policy before training, and now and then, of each seed."""
        return [point for course in self._courses.values() for point in course.points]

    def learned(self) -> list[LearnedController]:
        """The policy of each seed's best point."""
        controller = self._training.controller
        return [
            LearnedController(
                controller,
                course.weights,
                {
                    "seed": seed,
                    "episodes": course.points[-1].step,
                    "simulated_s": course.points[-1].simulated_s,
                    "best_fitness": course.best.fitness,
                    "best_episode": course.best.step,
                },
            )
            for seed in self._seeds
            if (course := self._courses.get(seed)) is not None
        ]

    def arrays(self) -> dict[str, np.ndarray]:
        """The curve and the best weights of each seed."""
        arrays = {}
        for seed, course in self._courses.items():
            arrays[f"seed{seed}_curve"] = np.array(course.points, "float64")
            arrays[f"seed{seed}_weights"] = np.asarray(course.weights)
        return arrays

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Leave the seeds that are done; one that was interrupted begins anew, to the same end."""
        n_weights = self._training.controller.n_weights
        courses = {}
        for name in arrays:
            if not name.endswith("_curve"):
                continue
            seed = int(name.removesuffix("_curve").removeprefix("seed"))
            weights = arrays[f"seed{seed}_weights"]
            rows = arrays[name]
            if weights.shape != (n_weights,) or not len(rows):
                raise ValueError("shapes differ")
            points = tuple(CurvePoint(seed, *map(float, row[1:])) for row in rows)
            courses[seed] = _Course(points, max(points, key=lambda p: p.fitness), weights)
        self._courses = courses


def _report(found: Point) -> str:
    """A point in words: by CoT⁻¹ where it is measured."""
    if math.isnan(found.cot_inverse):
        return f"fitness {found.fitness:+.3f}"
    return f"CoT⁻¹ {found.cot_inverse:.3f} m/J"
