"""Search space of one algorithm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from research.tuning.task import TuningTask
from tegotae.systems.experiment import Experiment
from tegotae.training.agents import AgentSettings
from tegotae.training.algorithms import Algorithm

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


Settings: TypeAlias = Algorithm | AgentSettings


@dataclass(frozen=True, kw_only=True)
class Space:
    """A search space, and how a point in it is evaluated.

    Args:
        suggest: from an Optuna trial to the algorithm's settings, a frozen dataclass. It may ask
            for a parameter only in one range, and reject none of the points in its ranges.
        learn: from settings, task, experiment and seeds to the fitness of the best that each seed
            found within the task's budget. It runs in another process, so it must be a function of
            a module.
        first: the parameters that are tried first, such as the settings known so far.
        least_episodes: episodes that a training needs at least, whatever its settings.
        seeds_at_once: seeds handed to one call of `learn`; after each call it is decided whether
            the settings are worth more.
    """

    suggest: Callable[[BaseTrial], Settings]
    learn: Callable[[Any, TuningTask, Experiment, tuple[int, ...]], list[float]]
    first: Mapping[str, float]
    least_episodes: int = 1
    seeds_at_once: int = 1
