"""Whether the feedback slows the oscillator while the actuator pushes.

Source: of this library, for the paper's "the oscillator is slowed down during actuation" (V).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    pushes = jnp.asarray(episode.trajectory.actuator_force_n) > 0.0
    return episode.where_settled(episode.mean_where(feedback, pushes))


METRIC = GaitMetric(
    name="feedback_while_pushing",
    label="f pushing",
    unit="rad/s",
    about="mean feedback while the actuator pushes; below zero it slows the oscillator",
    more_is_better=None,
    channels=("feedback_rad_per_s", "actuator_force_n"),
    shown=(),
    compute=_compute,
)
