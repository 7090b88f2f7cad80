"""Search space of CMA-ES."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.population import evolution, suggest_population, suggest_std
from tegotae.training.algorithms import CMAES

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> CMAES:
    """Suggest population and first step size: CMA-ES adapts everything else."""
    return CMAES(population=suggest_population(trial), std=suggest_std(trial))


SPACE = evolution(suggest=suggest, first={"log2_population": 6, "std": 0.3})
