"""CoT⁻¹ B, of all heights climbed.

Source: paper equation 12, the variant B of Fig. 4.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.catalogue.cot_inverse import over_cycles
from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import REPORT, TABLE, GaitMetric


def _compute(episode: Episode) -> jax.Array:
    return over_cycles(episode, episode.whole.climb_m)


METRIC = GaitMetric(
    name="cot_inverse_total",
    label="CoT⁻¹ B",
    unit="m/J",
    about="height climbed in flight and in stance per work, over the settled part",
    more_is_better=True,
    range=(0.0, float("inf")),
    channels=("work_absolute_j", "work_positive_j", "work_net_j", "climb_m"),
    shown=(TABLE, REPORT),
    compute=_compute,
)
