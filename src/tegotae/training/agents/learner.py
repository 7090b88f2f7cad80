"""An agent that learns: SAC, PPO, one seed after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from tegotae._support.documents import JsonObject
from tegotae._support.engines import XLA
from tegotae._support.errors import TegotaeError, require
from tegotae.parts.bodies import require_one_limb
from tegotae.parts.parameters import Part, whole
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import Release
from tegotae.training.agents import AgentSettings, SACSettings, agent_controller
from tegotae.training.algorithms import algorithm_document
from tegotae.training.learner import (
    Arrays,
    CurvePoint,
    LearnedController,
    Points,
    Trainable,
    TrainingState,
    versions_of,
)

if TYPE_CHECKING:
    from tegotae.training.run import Run


@dataclass(frozen=True, kw_only=True)
class AgentLearner(Part):
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
    episodes: int = whole(1000)
    evaluate_every: int = whole(10)

    UNIT: ClassVar[str] = "episode"

    @property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""
        require("stable_baselines3", "sb3")
        return versions_of("stable-baselines3", "torch", "gymnasium")

    def engine(self, experiment: Trainable) -> str:
        """XLA's: an agent acts within every episode, tick by tick."""
        return XLA

    def check(self, run: Run[Any]) -> None:
        """Raise `TegotaeError` for what an agent cannot learn.

        That is a controller without a meaning for agents; on the engine also a body of several
        limbs, conditions that change, an integrator or a release of its own.
        """
        if isinstance(run.experiment, Experiment):
            _check_on_engine(run.experiment)
        agent_controller(run.experiment, self.settings)

    def configuration(self, run: Run[Any]) -> JsonObject:
        """Return the settings that decide a seed's result, except the number of episodes, as JSON
        values."""
        experiment = run.experiment
        if isinstance(experiment, Experiment):
            experiment = experiment.replaced(objective=experiment.objective.without_frequency())
        return {
            "experiment": experiment.document,
            "algorithm": algorithm_document(self.settings),
            "evaluate_every": self.evaluate_every,
        }

    def length(self, run: Run[Any]) -> int:
        """Episodes of all seeds."""
        return len(run.seeds) * self.episodes

    def learn(self, run: Run[Any], state: TrainingState | None = None) -> Iterator[TrainingState]:
        """A point of a seed's learning curve each.

        Seeds that are done are left as they are; one that was interrupted begins anew, to the same
        end.

        Args:
            run: the training.
            state: where it goes on (`resumed`), or None from the beginning.
        """
        from tegotae.training.agents.learning import agent_task, learn

        points = () if state is None else state.points
        weights = {} if state is None else dict(state.arrays)
        lasted = {point.seed: point.step for point in points}
        finished = {seed for seed, step in lasted.items() if step >= self.episodes}
        points = tuple(point for point in points if point.seed in finished)
        task = agent_task(run.experiment, self.settings)
        for i, seed in enumerate(run.seeds):
            if seed in finished:
                continue
            best = -math.inf
            for point, reached in learn(
                task, seed=seed, episodes=self.episodes, evaluate_every=self.evaluate_every
            ):
                if point.fitness > best or best == -math.inf:
                    best, weights = point.fitness, {**weights, _weights_name(seed): reached}
                points = (*points, point)
                yield TrainingState(
                    i * self.episodes + min(round(point.step), self.episodes),
                    f"seed {seed}  {_report(point)}",
                    points,
                    (point,),
                    self._learned(run, points, weights),
                    weights,
                )

    def resumed(self, run: Run[Any], points: Points, arrays: Arrays) -> TrainingState:
        """Restore a training with the best weights of every seed that has begun.

        Raises:
            ValueError or KeyError: for arrays of another training.
        """
        shape = (run.experiment.controller.n_weights,)
        if any(arrays[_weights_name(point.seed)].shape != shape for point in points):
            raise ValueError("shapes differ")
        learned = self._learned(run, points, arrays)
        return TrainingState(points=points, learned=learned, arrays=arrays)

    def _learned(
        self, run: Run[Any], points: Points, weights: Arrays
    ) -> tuple[LearnedController, ...]:
        """The policy of each seed's best point."""
        learned = []
        for seed in run.seeds:
            curve = [point for point in points if point.seed == seed]
            if curve:
                best = max(curve, key=lambda point: point.fitness)
                outcome = {
                    "seed": seed,
                    "episodes": curve[-1].step,
                    "simulated_s": curve[-1].simulated_s,
                    "best_fitness": best.fitness,
                    "best_episode": best.step,
                }
                policy = agent_controller(run.experiment, self.settings)
                learned.append(LearnedController(policy, weights[_weights_name(seed)], outcome))
        return tuple(learned)


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


def _weights_name(seed: int) -> str:
    """Return the name of a seed's best weights in a checkpoint."""
    return f"seed{seed}_weights"


def _report(point: CurvePoint) -> str:
    """A point in words: by CoT⁻¹ where it is measured."""
    if math.isnan(point.cot_inverse):
        return f"fitness {point.fitness:+.3f}"
    return f"CoT⁻¹ {point.cot_inverse:.3f} m/J"
