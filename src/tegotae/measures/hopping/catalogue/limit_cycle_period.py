"""The period of the limit cycle.

Source: of this library; the paper (IV-A) asks for a limit cycle of any period.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    return episode.where_settled(episode.cycle.period)


METRIC = GaitMetric(
    name="limit_cycle_period",
    label="period",
    unit="hops",
    about="hops after which the limit cycle repeats itself",
    more_is_better=None,
    range=(1.0, float("inf")),
    shown=(),
    compute=_compute,
)
