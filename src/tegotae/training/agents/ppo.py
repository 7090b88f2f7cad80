"""PPO on the feedback law."""

from __future__ import annotations

import math
from typing import Any

from tegotae._support.optional_dependencies import require
from tegotae.training.agents.actor import Feedback
from tegotae.training.agents.settings import PPOSettings

require("stable_baselines3", "sb3")

from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.policies import ActorCriticPolicy  # noqa: E402
from stable_baselines3.common.type_aliases import Schedule  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402
from torch import nn  # noqa: E402


class FeedbackPPOPolicy(ActorCriticPolicy):
    """SB3's policy, its actor a Gaussian of learned, constant deviation around tanh(G A′ R / L)."""

    def __init__(self, *args: Any, feedback: Feedback, **options: Any) -> None:
        # Modules cannot be assigned before SB3's constructor, which already builds the networks.
        self._parts = (feedback,)
        super().__init__(*args, **options)

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Sequential(*self._parts, nn.Tanh())
        self.optimizer = self.optimizer_class(
            self.parameters(),
            lr=lr_schedule(1),  # type: ignore[call-arg]
            **self.optimizer_kwargs,
        )


def make_ppo(settings: PPOSettings, env: VecEnv, feedback: Feedback, seed: int) -> PPO:
    """The agent, not yet trained."""
    return PPO(
        FeedbackPPOPolicy,
        env,
        learning_rate=settings.learning_rate,
        n_steps=settings.n_steps,
        batch_size=settings.batch_size,
        n_epochs=settings.n_epochs,
        gamma=settings.gamma,
        gae_lambda=settings.gae_lambda,
        clip_range=settings.clip_range,
        ent_coef=settings.ent_coef,
        vf_coef=settings.vf_coef,
        max_grad_norm=settings.max_grad_norm,
        policy_kwargs={
            "feedback": feedback,
            "log_std_init": math.log(settings.noise),
            "net_arch": {"pi": [], "vf": list(settings.critic_layers)},
        },
        seed=seed,
        device="cpu",
    )
