"""How pure the body's oscillation is.

Source: paper equation 13, A_peak.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric


def _compute(episode: Episode) -> jax.Array:
    return episode.where_settled(episode.peak[1])


METRIC = GaitMetric(
    name="a_peak",
    label="A peak",
    math=r"$A_\mathrm{peak}$",
    about="square root of the power's share in the spectrum's highest peak",
    more_is_better=None,
    range=(0.0, 1.0),
    channels=("height_m",),
    shown=(),
    compute=_compute,
)
