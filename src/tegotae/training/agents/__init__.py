"""Agents that learn the feedback law step by step: SAC and PPO, through Stable-Baselines3.

Settings and names are here for everyone; what needs torch is imported when something is learned.
"""

from tegotae.training.agents.policy import agent_controller, initial_weights
from tegotae.training.agents.run import AgentRun, train_agents
from tegotae.training.agents.settings import AgentSettings, PPOSettings, SACSettings

__all__ = [
    "AgentRun",
    "AgentSettings",
    "PPOSettings",
    "SACSettings",
    "agent_controller",
    "initial_weights",
    "train_agents",
]
