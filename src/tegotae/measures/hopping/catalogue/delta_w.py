"""Δw, how far the spectrum's peaks are from the prescribed frequency.

Source: paper equation 14.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import GaitMetric
from tegotae.measures.hopping.signals import delta_w


def _compute(episode: Episode) -> jax.Array:
    return episode.where_settled(delta_w(episode.spectrum, episode.omega))


METRIC = GaitMetric(
    name="delta_w",
    label="Δw",
    unit="rad/s",
    about="distance of the spectrum's peaks from ω (equation 14)",
    more_is_better=False,
    range=(0.0, float("inf")),
    channels=("height_m",),
    parameters=("omega",),
    compute=_compute,
)
