"""Parts that the spaces of all evolution strategies share."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from research.tuning.spaces.base import Space
from research.tuning.task import TuningTask
from tegotae.systems.experiment import Experiment
from tegotae.training.algorithms import Algorithm
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run

if TYPE_CHECKING:
    from optuna.trial import BaseTrial

_LOG2_SMALLEST, _LOG2_LARGEST = 4, 7


def suggest_population(trial: BaseTrial) -> int:
    """Suggest 16, 32, 64 or 128 episodes per generation: each is a program to compile."""
    return 2 ** trial.suggest_int("log2_population", _LOG2_SMALLEST, _LOG2_LARGEST)


def suggest_std(trial: BaseTrial) -> float:
    """Suggest an initial standard deviation of the weights, themselves of order one."""
    return trial.suggest_float("std", 0.02, 1.0, log=True)


def evolved(
    settings: Algorithm, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    """Return the fitness of each seed's best distribution, of as many whole generations as the
    budget has.
    """
    episodes = task.episodes(experiment, minimum=settings.population)
    run = Run(
        experiment=experiment,
        seeds=seeds,
        learner=Evolution(
            algorithm=settings, stopping=Stopping.after(episodes // settings.population)
        ),
    )
    ((progress, _),) = deque(
        run.learner.evolve(run.experiment, run.seeds),
        maxlen=1,
    )
    return [float(fitness) for fitness in np.asarray(progress.best_fitness)]


def evolution(*, suggest: Callable[[BaseTrial], Algorithm], first: Mapping[str, float]) -> Space:
    """Return the space of an evolution strategy."""
    return Space(
        suggest=suggest,
        learn=evolved,
        first=first,
        least_episodes=2**_LOG2_LARGEST,
        # Seeds are trained side by side, so that more of them hardly take longer.
        seeds_at_once=8,
    )
