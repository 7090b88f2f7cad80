"""T0, how long a gait takes to settle.

Source: paper IV-A, T0.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    return episode.where_settled(episode.cycle.time_s)


METRIC = GaitMetric(
    name="t0_s",
    label="T0",
    unit="s",
    about="time from release until settled",
    more_is_better=False,
    range=(0.0, float("inf")),
    compute=_compute,
)
