"""Spaces of the hopper environments, and their pose to draw."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box

from tegotae.envs.core import TELEMETRY, EnvStep, observation_bounds
from tegotae.envs.rendering import Pose
from tegotae.envs.settings import HopperSettings


def action_space() -> Box:
    """One number in [-1, 1]."""
    return Box(-1.0, 1.0, (1,), np.float32)


def observation_space(settings: HopperSettings) -> Box:
    """The observed entries in their bounds."""
    bounds = observation_bounds(settings)
    one_sided = np.array([name == "spring_force" for name in settings.observed])
    return Box(np.where(one_sided, np.float32(0.0), -bounds), bounds, dtype=np.float32)


def pose(settings: HopperSettings, step: EnvStep, lane: int) -> Pose:
    """What there is to draw of one lane."""
    now = dict(zip(TELEMETRY, step.telemetry[lane].tolist(), strict=True))
    return Pose(
        height_m=now["height_m"],
        ground_m=now["ground_m"],
        rest_length_m=settings.body.rest_length_m,
        push_share=now["actuator_force_n"] / settings.body.max_force_n,
        phase_rad=None if settings.controller.oscillator is None else now["phase_rad"],
    )
