"""Parts that the spaces of all agents share."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, TypedDict

from research.tuning.task import TuningTask
from tegotae.systems.experiment import Experiment
from tegotae.training.agents import AgentSettings

if TYPE_CHECKING:
    from optuna.trial import BaseTrial

_POINTS = 20
"""Evaluations in a training: as seldom as the best of them allows."""


class SharedSettings(TypedDict):
    """The searched settings of every agent."""

    gamma: float
    learning_rate: float
    noise: float
    normalize_reward: bool


def suggest_shared(trial: BaseTrial, step_s: float = 0.01) -> SharedSettings:
    """Suggest discount (as a horizon in time), step size, noise, and whether rewards are
    normalised.
    """
    horizon_s = trial.suggest_float("horizon_s", 0.2, 20.0, log=True)
    return {
        "gamma": 1.0 - step_s / horizon_s,
        "learning_rate": trial.suggest_float("learning_rate", 1e-4, 1e-2, log=True),
        "noise": trial.suggest_float("noise", 0.01, 0.5, log=True),
        "normalize_reward": trial.suggest_categorical("normalize_reward", [False, True]),
    }


SHARED_FIRST = {
    "horizon_s": 2.0,
    "learning_rate": 3e-4,
    "noise": 0.1,
    "normalize_reward": False,
}
"""The settings' own defaults."""


def learned(
    settings: AgentSettings, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    """Return the fitness of each seed's best policy in the budget, or its value so far if
    learning diverges.
    """
    from tegotae.training.agents.learning import DivergedError, agent_task, learn

    training = agent_task(experiment, settings)
    episodes = task.episodes(experiment, minimum=1)
    best = []
    for seed in seeds:
        fitness = []
        with suppress(DivergedError):
            for point, _ in learn(
                training, seed=seed, episodes=episodes, evaluate_every=max(1, episodes // _POINTS)
            ):
                fitness.append(point.fitness)
        best.append(max(fitness))
    return best
