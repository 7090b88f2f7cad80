"""SAC on the feedback law."""

from __future__ import annotations

import math
from typing import Any

from tegotae._support.optional_dependencies import require
from tegotae.training.agents.actor import Feedback
from tegotae.training.agents.settings import SACSettings

require("stable_baselines3", "sb3")

import torch  # noqa: E402
from stable_baselines3 import SAC  # noqa: E402
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402
from stable_baselines3.sac.policies import Actor, SACPolicy  # noqa: E402
from torch import nn  # noqa: E402


class _StateIndependent(nn.Module):
    """The same number for every observation."""

    def __init__(self, value: float) -> None:
        super().__init__()
        self.value = nn.Parameter(torch.tensor([value]))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to the number, [batch, 1]."""
        return self.value.expand(observations.shape[0], 1)


class FeedbackSACPolicy(SACPolicy):
    """SB3's policy, its actor `tanh(G A′ R / L + noise)` with a learned, constant deviation."""

    def __init__(self, *args: Any, feedback: Feedback, noise: float, **options: Any) -> None:
        # Modules cannot be assigned before SB3's constructor, which already asks for the actor.
        self._parts = (feedback, noise)
        super().__init__(*args, **options)

    def make_actor(self, features_extractor: BaseFeaturesExtractor | None = None) -> Actor:
        """SB3's actor with the feedback law in the place of its network."""
        actor = super().make_actor(features_extractor)
        feedback, noise = self._parts
        actor.mu = feedback  # type: ignore[assignment]
        actor.log_std = _StateIndependent(math.log(noise))  # type: ignore[assignment]
        return actor.to(self.device)


def make_sac(settings: SACSettings, env: VecEnv, feedback: Feedback, seed: int) -> SAC:
    """The agent, not yet trained."""
    return SAC(
        FeedbackSACPolicy,
        env,
        learning_rate=settings.learning_rate,
        buffer_size=settings.buffer_size,
        learning_starts=settings.learning_starts,
        batch_size=settings.batch_size,
        tau=settings.tau,
        gamma=settings.gamma,
        train_freq=settings.train_freq,
        gradient_steps=settings.gradient_steps,
        n_steps=settings.td_steps,
        target_entropy=settings.target_entropy * feedback.limbs,
        policy_kwargs={
            "feedback": feedback,
            "noise": settings.noise,
            "net_arch": {"pi": [], "qf": list(settings.critic_layers)},
            # One call for all parameters: networks as small as these are all overhead.
            "optimizer_kwargs": {"fused": True},
        },
        seed=seed,
        device="cpu",
    )
