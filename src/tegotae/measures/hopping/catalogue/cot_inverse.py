"""CoT⁻¹ A, of the heights climbed in flight.

Source: paper equation 12, the variant A of Fig. 4.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import AT_REST, Episode
from tegotae.measures.hopping.metric import GaitMetric
from tegotae.measures.hopping.signals import cot_inverse
from tegotae.parts._shapes import AnyArray


def over_cycles(episode: Episode, climbed_m: AnyArray) -> jax.Array:
    """CoT⁻¹ of a running total of climbed heights [m], [frames, lanes], over whole cycles [m/J].

    Zero for a body at rest or one that does no work, and undefined without a limit cycle.
    """
    done = episode.work_j
    # Negative work (and work that was not recorded) has no efficiency.
    value = jnp.where(done > -1e-6, cot_inverse(episode.over_cycles(climbed_m), done), jnp.nan)
    return jnp.where(episode.regime == AT_REST, 0.0, episode.where_settled(value))


def _compute(episode: Episode) -> jax.Array:
    return over_cycles(episode, episode.whole.climb_flight_m)


METRIC = GaitMetric(
    name="cot_inverse",
    label="CoT⁻¹",
    unit="m/J",
    about="height climbed in flight per work, over the settled part (equation 12)",
    more_is_better=True,
    range=(0.0, float("inf")),
    channels=("work_absolute_j", "work_positive_j", "work_net_j", "climb_flight_m"),
    compute=_compute,
)
