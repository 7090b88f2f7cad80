"""Search space of OpenAI-ES."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.population import evolution, suggest_population, suggest_std
from tegotae.training.algorithms import OpenES

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> OpenES:
    """Suggest population, deviation and Adam's step size."""
    return OpenES(
        population=suggest_population(trial),
        std=suggest_std(trial),
        learning_rate=trial.suggest_float("learning_rate", 0.005, 0.5, log=True),
    )


SPACE = evolution(suggest=suggest, first={"log2_population": 6, "std": 0.2, "learning_rate": 0.05})
