"""A user's file with a metric of a hopper, one of several legs, and one of a robot."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from tegotae.measures.gaits.metrics import WalkMetric
from tegotae.measures.hopping import GaitMetric
from tegotae.measures.robots import RobotMetric


@GaitMetric.described(label="first apex", unit="m", more_is_better=None)
def first_apex_m(episode):
    """height of the first apex"""
    return jnp.asarray(episode.hops.height_m)[0]


@WalkMetric.described(
    label="largest pitch", unit="rad", more_is_better=False, channels=("pitch_rad",)
)
def largest_pitch_rad(walks):
    """largest pitch of the torso since the release"""
    return np.abs(walks["pitch_rad"]).max(axis=0)


@RobotMetric.described(label="largest action", more_is_better=False)
def largest_action(episode):
    """largest magnitude of an action"""
    return np.abs(episode.action).max()
