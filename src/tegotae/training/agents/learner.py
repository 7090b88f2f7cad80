"""An agent that learns: SAC, PPO, one seed after the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.engines import XLA
from tegotae._support.errors import TegotaeError, require
from tegotae.parts.bodies import require_one_limb
from tegotae.parts.controller import Controller
from tegotae.parts.parameters import whole
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.systems.experiment import Experiment, Trainable
from tegotae.systems.system import Release
from tegotae.training.agents import AgentSettings, SACSettings, agent_controller
from tegotae.training.algorithms import algorithm_document
from tegotae.training.learner import CurvePoint, SeedLearner, versions_of

if TYPE_CHECKING:
    from tegotae.training.run import Run


@dataclass(frozen=True, kw_only=True)
class AgentLearner(SeedLearner):
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
        """Return XLA's engine: an agent acts within every episode, tick by tick."""
        return XLA

    def check(self, run: Run[Any]) -> None:
        """Raise `TegotaeError` for an experiment that an agent cannot learn.

        That is a controller without a meaning for agents; on the engine also a body of several
        limbs, conditions that change, an integrator or a release of its own.
        """
        if run.experiment.task is None:
            _check_on_engine(run.experiment)  # type: ignore[arg-type]
        agent_controller(run.experiment, self.settings)

    def configuration(self, run: Run[Any]) -> JsonObject:
        """Return the settings that decide a seed's result, except the number of episodes, as JSON
        values."""
        return {
            "experiment": run.experiment.without_frequency().document,
            "algorithm": algorithm_document(self.settings),
            "evaluate_every": self.evaluate_every,
        }

    @property
    def steps(self) -> int:
        """Episodes of each seed."""
        return self.episodes

    def curve(self, experiment: Trainable, seed: int) -> Iterator[tuple[CurvePoint, np.ndarray]]:
        """Train an agent, and yield its policies.

        Args:
            experiment: what is trained.
            seed: of the weights and of all that is drawn.
        """
        from tegotae.training.agents.learning import agent_task, learn

        task = agent_task(experiment, self.settings)
        yield from learn(
            task, seed=seed, episodes=self.episodes, evaluate_every=self.evaluate_every
        )

    def policy(self, experiment: Trainable) -> Controller:
        """Return the deterministic policy."""
        return agent_controller(experiment, self.settings)


def _check_on_engine(experiment: Experiment) -> None:
    """Raise `TegotaeError` for a difference between episodes, or from the options of the hopper."""
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
