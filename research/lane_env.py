"""Lanes of a simulation as the environments of Stable-Baselines3."""

from __future__ import annotations

import numpy as np
from stable_baselines3.common.vec_env import VecEnv


class LaneEnv(VecEnv):
    """Environments that are stepped together and have no other methods."""

    actions: np.ndarray
    """Actions of the present step, [lanes, actions]."""

    def step_async(self, actions: np.ndarray) -> None:
        self.actions = actions

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * self.num_envs

    def env_method(self, name, *args, indices=None, **kwargs):
        raise NotImplementedError

    def get_attr(self, name, indices=None):
        return [getattr(self, name, None)] * self.num_envs

    def set_attr(self, name, value, indices=None):
        raise NotImplementedError
