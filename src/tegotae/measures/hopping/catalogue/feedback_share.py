"""How large the feedback is beside the frequency.

Source: of this library, for the paper's "switches off the oscillator feedback mechanism" (V).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import REPORT, GaitMetric


def _compute(episode: Episode) -> jax.Array:
    """Mean |f| over ω + mean |f|, over the settled part: 0 if the feedback is off."""
    feedback = jnp.abs(jnp.asarray(episode.trajectory.feedback_rad_per_s))
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    mean = episode.mean_where(feedback, True)
    return episode.where_settled(mean / (jnp.asarray(episode.omega) + mean))


METRIC = GaitMetric(
    name="feedback_share",
    label="by feedback",
    about="size of the feedback, mean |f| over ω + mean |f|",
    more_is_better=None,
    range=(0.0, 1.0),
    channels=("feedback_rad_per_s",),
    parameters=("omega",),
    shown=(REPORT,),
    compute=_compute,
)
