"""Search space of PPO."""

from __future__ import annotations

from typing import TYPE_CHECKING

from research.tuning.spaces.agent import SHARED_FIRST, learned, suggest_shared
from research.tuning.spaces.base import Space
from tegotae.training.agents import PPOSettings

if TYPE_CHECKING:
    from optuna.trial import BaseTrial


def suggest(trial: BaseTrial) -> PPOSettings:
    """Suggest the horizon of rewards, the learning rate, the exploration, and the gathering of
    data."""
    return PPOSettings(
        **suggest_shared(trial),
        n_steps=60 * 2 ** trial.suggest_int("log2_n_steps_over_60", 0, 4),
        n_epochs=trial.suggest_int("n_epochs", 2, 20),
        gae_lambda=1.0 - trial.suggest_float("gae_forgetting", 0.001, 0.2, log=True),
        clip_range=trial.suggest_float("clip_range", 0.05, 0.5, log=True),
        ent_coef=trial.suggest_float("ent_coef", 0.0, 0.03),
    )


SPACE = Space(
    suggest=suggest,
    learn=learned,
    first={
        **SHARED_FIRST,
        "log2_n_steps_over_60": 1,
        "n_epochs": 10,
        "gae_forgetting": 0.05,
        "clip_range": 0.2,
        "ent_coef": 0.0,
    },
)
