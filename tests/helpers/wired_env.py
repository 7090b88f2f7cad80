"""Environments to train on in tests: a scale that is stood on in turns, and ways to go wrong."""

import math
import os
import sys
import time
from typing import ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Box

STEPS = 40


class Scales(gymnasium.Env):
    """A foot that presses in turns; paid for pushing while it does. Pushing may `fail` it."""

    metadata: ClassVar = {"render_modes": []}
    observation_names = ("load", "height", "work")
    dt = 0.02

    def __init__(self, fail: str = ""):
        self.observation_space = Box(-np.inf, np.inf, (3,), np.float64)
        self.action_space = Box(np.float32([0.0]), np.float32([1.0]))
        self.fail = fail

    def _seen(self):
        swing = math.sin(8.0 * self.n * self.dt)
        return np.array([max(0.0, swing), 1.0 - 0.1 * swing, self.work])

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        if self.fail == "reset" and seed:
            raise RuntimeError("nobody is at home")
        self.n, self.work = 0, 0.0
        return self._seen(), {}

    def step(self, action):
        self.n += 1
        push = float(action[0])
        self.work += push * self.dt
        if push > 0.5 and self.fail:
            return self._fail()
        observation = self._seen()
        return observation, push * observation[0] - 0.2 * push, False, self.n >= STEPS, {}

    def _fail(self):
        observed = self._seen()
        if self.fail == "raise":
            raise RuntimeError("the motor is on fire")
        if self.fail == "leave":
            sys.exit(0)
        if self.fail == "exit":
            os._exit(3)
        if self.fail == "hang":
            time.sleep(600.0)
        if self.fail == "nan":
            return observed * np.nan, 0.0, False, False, {}
        if self.fail == "pay":
            return observed, math.inf, False, False, {}
        return observed[:2], 0.0, False, False, {}  # of another shape


class AtOnce(Scales):
    """Over at its first step, if one pushes."""

    def step(self, action):
        return self._seen(), 0.0, float(action[0]) > 0.5, False, {}


def pushes(episode):
    """A fitness of one's own: how much was pushed."""
    assert episode["load"].shape == episode.time_s.shape == episode.reward.shape
    return episode.action[:, 0].mean()


def last_push(episode):
    """A fitness that takes an episode of one step at least."""
    return episode["work"][-1]


def of_no_entry(episode):
    """Asks for what is not observed."""
    return episode["lod"].mean()


def divides(episode):
    """Fails."""
    return 1 / 0


def text(episode):
    """No number."""
    return "much"


def undefined(episode):
    """Never a number."""
    return float("nan")


def nothing():
    """No environment."""
    return 5
