"""Search space of SNES."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.population import evolution, suggest_population, suggest_std
from tegotae.training.algorithms import SNES

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> SNES:
    """Suggest population and first deviation: SNES adapts everything else."""
    return SNES(population=suggest_population(trial), std=suggest_std(trial))


SPACE = evolution(suggest=suggest, first={"log2_population": 5, "std": 0.3})
