"""Search space of PGPE."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.population import evolution, suggest_population, suggest_std
from tegotae.training.algorithms import PGPE

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> PGPE:
    """Suggest all of PGPE's settings but the largest change of a deviation (the paper's) and
    momentum.
    """
    learning_rate = trial.suggest_float("learning_rate", 0.02, 1.0, log=True)
    return PGPE(
        population=suggest_population(trial),
        std=suggest_std(trial),
        std_lr=trial.suggest_float("std_lr", 0.01, 1.0, log=True),
        learning_rate=learning_rate,
        max_speed=learning_rate * trial.suggest_float("speed_ratio", 1.0, 8.0, log=True),
    )


SPACE = evolution(
    suggest=suggest,
    first={
        "log2_population": 6,
        "std": 0.3,
        "std_lr": 0.1,
        "learning_rate": 0.2,
        "speed_ratio": 2.0,
    },
)
