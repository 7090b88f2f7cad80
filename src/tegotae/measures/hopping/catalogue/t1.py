"""T1, how long a gait takes to settle again after the ground dropped.

Source: paper IV-A, T1.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    if episode.disturbed_at_s is None:
        return jnp.full_like(episode.cycle.time_s, jnp.nan)
    touchdowns = jnp.asarray(episode.whole.touchdown_time_s)
    after = touchdowns > jnp.asarray(episode.disturbed_at_s, touchdowns.dtype).reshape(1, -1)
    touchdown = jnp.min(jnp.where(after, touchdowns, jnp.inf), axis=0)
    again = episode.settles_again(touchdown)
    fell = episode.whole.failed[-1]
    return episode.where_settled(jnp.where(fell, jnp.nan, again.time_s - touchdown))


METRIC = GaitMetric(
    name="t1_s",
    label="T1",
    unit="s",
    about="time from the first touchdown after a drop of the ground until settled again",
    more_is_better=False,
    range=(0.0, float("inf")),
    disturbed=True,
    compute=_compute,
)
