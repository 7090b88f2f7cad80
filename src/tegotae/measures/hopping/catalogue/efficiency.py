"""How much of the work becomes height, and how smoothly the actuator works."""

from __future__ import annotations

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.metric import (
    AT_REST,
    REPORT,
    TABLE,
    Conditions,
    DerivedMetric,
    Episode,
    GaitMetric,
)
from tegotae.measures.hopping.signals import cot_inverse, smoothness
from tegotae.measures.hopping.statistics import POSITIVE
from tegotae.measures.optimum import has_table, share
from tegotae.parts._shapes import AnyArray


def over_cycles(episode: Episode, climbed_m: AnyArray) -> jax.Array:
    """CoT⁻¹ of a running total of climbed heights [m], [frames, lanes], over whole cycles [m/J].

    Zero for a body at rest or one that does no work, and undefined without a limit cycle.
    """
    done = episode.work_j
    # Negative work (and work that was not recorded) has no efficiency.
    value = jnp.where(done > -1e-6, cot_inverse(episode.over_cycles(climbed_m), done), jnp.nan)
    return jnp.where(episode.regime == AT_REST, 0.0, episode.where_settled(value))


# Source: paper equation 12, the variant A of Fig. 4.
COT_INVERSE = GaitMetric(
    name="cot_inverse",
    label="CoT⁻¹",
    unit="m/J",
    about="height climbed in flight per work, over the settled part (equation 12)",
    more_is_better=True,
    range=POSITIVE,
    channels=("work_absolute_j", "work_positive_j", "work_net_j", "climb_flight_m"),
    compute=lambda episode: over_cycles(episode, episode.whole.climb_flight_m),
)


# Source: paper equation 12, the variant B of Fig. 4.
COT_INVERSE_TOTAL = GaitMetric(
    name="cot_inverse_total",
    label="CoT⁻¹ B",
    unit="m/J",
    about="height climbed in flight and in stance per work, over the settled part",
    more_is_better=True,
    range=POSITIVE,
    channels=("work_absolute_j", "work_positive_j", "work_net_j", "climb_m"),
    shown=(TABLE, REPORT),
    compute=lambda episode: over_cycles(episode, episode.whole.climb_m),
)


def _optimum_share(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    cot, rate = values["cot_inverse"], values["hop_rate"]
    if not has_table(conditions.body, conditions.work):
        return np.full(np.shape(cot), np.nan)
    return share(cot, rate, values["limit_cycle_period"])


# Source: of this library (`tegotae.measures.optimum`).
OPTIMUM_SHARE = DerivedMetric(
    name="optimum_share",
    label="of optimum",
    about="CoT⁻¹ over the largest that any force can have at the gait's own hop rate",
    more_is_better=True,
    range=POSITIVE,
    of=("cot_inverse", "hop_rate", "limit_cycle_period"),
    compute=_optimum_share,
    needs_body=True,
)


def _smoothness(episode: Episode) -> jax.Array:
    impulse_ns = episode.trajectory.impulse_ns
    value = smoothness(impulse_ns, episode.max_force_n, episode.frame_s, episode.start_s)
    return episode.where_settled(value)


# Source: of this library; the paper (V) calls actuation smooth and gives no measure.
SMOOTHNESS = GaitMetric(
    name="smoothness",
    label="dF/dt",
    unit="1/s",
    about="root-mean-square rate of change of the actuator force over its largest value",
    more_is_better=False,
    range=POSITIVE,
    channels=("impulse_ns",),
    parameters=("max_force_n",),
    shown=(TABLE, REPORT),
    compute=_smoothness,
)
