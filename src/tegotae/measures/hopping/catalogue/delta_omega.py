"""ΔΩ, how far a gait is from a pure oscillation at the prescribed frequency.

Source: paper equation 13.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import REPORT, TABLE, GaitMetric
from tegotae.measures.hopping.signals import delta_omega


def _compute(episode: Episode) -> jax.Array:
    if not episode.has_oscillator:  # no prescribed frequency to deviate from, as in the fitness
        return episode.where_settled(jnp.zeros_like(episode.cycle.time_s))
    return episode.where_settled(delta_omega(episode.omega, *episode.peak))


METRIC = GaitMetric(
    name="delta_omega",
    label="ΔΩ",
    unit="rad²/s²",
    about="deviation from a pure oscillation at ω (equation 13)",
    more_is_better=True,
    range=(-float("inf"), 0.0),
    channels=("height_m",),
    parameters=("omega",),
    shown=(TABLE, REPORT),
    compute=_compute,
)
