"""The frequency at which the body's height mostly oscillates.

Source: paper equation 13, w_peak.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    return episode.where_settled(episode.peak[0])


METRIC = GaitMetric(
    name="w_peak",
    label="w peak",
    math=r"$w_\mathrm{peak}$",
    unit="rad/s",
    about="frequency of the highest peak of the height's spectrum, over the settled part",
    more_is_better=None,
    range=(0.0, float("inf")),
    channels=("height_m",),
    shown=(),
    compute=_compute,
)
