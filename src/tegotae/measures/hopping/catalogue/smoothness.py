"""How smoothly the actuator force changes.

Source: of this library; the paper (V) calls actuation smooth and gives no measure.
"""

from __future__ import annotations

import jax

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import REPORT, TABLE, GaitMetric
from tegotae.measures.hopping.signals import smoothness


def _compute(episode: Episode) -> jax.Array:
    impulse_ns = episode.trajectory.impulse_ns
    value = smoothness(impulse_ns, episode.max_force_n, episode.frame_s, episode.start_s)
    return episode.where_settled(value)


METRIC = GaitMetric(
    name="smoothness",
    label="dF/dt",
    unit="1/s",
    about="root-mean-square rate of change of the actuator force over its largest value",
    more_is_better=False,
    range=(0.0, float("inf")),
    channels=("impulse_ns",),
    parameters=("max_force_n",),
    shown=(TABLE, REPORT),
    compute=_compute,
)
