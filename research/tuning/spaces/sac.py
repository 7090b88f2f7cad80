"""Search space of SAC."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.agent import SHARED_FIRST, learned, suggest_shared
from research.tuning.spaces.base import Space
from tegotae.training.agents import SACSettings

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> SACSettings:
    """Suggest the horizon of rewards, the learning rate and the exploration; the number of updates
    is fixed."""
    return SACSettings(
        **suggest_shared(trial),
        td_steps=2 ** trial.suggest_int("log2_td_steps", 0, 6),
        tau=trial.suggest_float("tau", 0.001, 0.05, log=True),
        target_entropy=trial.suggest_float("target_entropy", -4.0, 0.5),
    )


SPACE = Space(
    suggest=suggest,
    learn=learned,
    first={**SHARED_FIRST, "log2_td_steps": 0, "tau": 0.005, "target_entropy": -1.0},
)
