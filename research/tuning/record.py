"""A tuning in a few numbers: the settings found, and how."""

from __future__ import annotations

import dataclasses
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from research.tuning.spaces import Space
from research.tuning.spaces.base import Settings
from research.tuning.task import TuningTask
from research.tuning.tuner import P_PRUNED
from tegotae._support.engines import selected
from tegotae._support.errors import TegotaeError, require
from tegotae.measures.statistics import Interval, interval, paired_difference
from tegotae.training.learner import versions_of

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial


class TunedSettings(TypedDict):
    """A named configuration, as JSON values."""

    algorithm: str
    settings: dict[str, object]
    found: dict[str, Any]
    """Origin of the settings: task, number of trials and loss."""


class Confirmation(TypedDict):
    """Results of settings on fresh trainings: mean and ends of an interval each, as JSON values."""

    first_seed: int
    seeds: int
    best: Mapping[str, float]
    tried_first: Mapping[str, float]
    difference: Mapping[str, float]


def ranking(trials: Sequence[FrozenTrial]) -> list[FrozenTrial]:
    """Return the completed trials, the best first.

    Raises:
        TegotaeError: if no trial is complete.
    """
    complete = [trial for trial in trials if trial.state.name == "COMPLETE"]
    if not complete:
        raise TegotaeError("no trial is complete; try more settings with --trials")
    return sorted(complete, key=lambda trial: trial.value or 0.0, reverse=True)


def tried_first(space: Space) -> Settings:
    """Return the settings with which every search of a space begins."""
    trial = require("optuna", "tune").trial.FixedTrial(dict(space.first))
    return space.suggest(trial)


def describe(
    algorithm: str, task: TuningTask, space: Space, trials: Sequence[FrozenTrial]
) -> TunedSettings:
    """Return the best settings and the data of their search, as JSON values: a named configuration.

    Args:
        algorithm: its name.
        task: what was tried on.
        space: what was tried.
        trials: all of them.

    Raises:
        TegotaeError: if no trial is complete.
    """
    ranked = ranking(trials)
    best = ranked[0]
    first = next((trial.value for trial in ranked if trial.params == space.first), None)
    states = Counter(trial.state.name.lower() for trial in trials)
    return {
        "algorithm": algorithm,
        "settings": dataclasses.asdict(space.suggest(best)),
        "found": {
            "task": task.configuration,
            "trials": {name: states[name] for name in ("complete", "pruned", "fail")},
            "search": f"Optuna, TPESampler, WilcoxonPruner(p_threshold={P_PRUNED})",
            "mean_fitness": best.value,
            "fitness": [best.intermediate_values[i] for i in sorted(best.intermediate_values)],
            "trial": best.number,
            "tried_first": {
                "settings": dataclasses.asdict(tried_first(space)),
                "mean_fitness": first,
            },
            "date": time.strftime("%Y-%m-%d", time.gmtime()),
            "software": {**versions_of("evosax", "optuna"), "engine": selected()},
        },
    }


def confirmation(task: TuningTask, first: np.ndarray, best: np.ndarray) -> Confirmation:
    """Compare the first and the best settings on trainings that did not choose them.

    The intervals are over all trainings, models and seeds alike, the difference's over pairs.

    Args:
        task: the fresh trainings.
        first: fitness with the settings tried first, shape [instances].
        best: the same with the best settings.
    """

    def numbers(estimate: Interval) -> Mapping[str, float]:
        return {"mean": estimate.mean, "low": estimate.low, "high": estimate.high}

    return {
        "first_seed": task.first_seed,
        "seeds": task.seeds,
        "best": numbers(interval(best)),
        "tried_first": numbers(interval(first)),
        "difference": numbers(paired_difference(best, first)),
    }
