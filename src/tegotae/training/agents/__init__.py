"""Agents that learn the feedback law step by step: SAC and PPO, through Stable-Baselines3.

Settings and names are here for everyone; what needs torch is imported when something is learned.
"""

from tegotae.training.agents.learner import AgentLearner
from tegotae.training.agents.settings import (
    AgentSettings,
    PPOSettings,
    SACSettings,
    agent_controller,
    initial_weights,
)

__all__ = [
    "AgentLearner",
    "AgentSettings",
    "PPOSettings",
    "SACSettings",
    "agent_controller",
    "initial_weights",
]
