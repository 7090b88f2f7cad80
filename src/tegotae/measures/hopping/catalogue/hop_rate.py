"""The hop frequency: hops over time.

Source: of this library.
"""

from __future__ import annotations

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import (
    REPORT,
    TABLE,
    Conditions,
    Derivation,
    GaitMetric,
)

_PURE = 0.9
"""A peak of so large an A_peak is that of the hops, and no harmonic's."""


def _compute(episode: Episode) -> jax.Array:
    cycle = episode.cycle
    cycles_s = episode.apex_s(cycle.to_hop) - episode.apex_s(cycle.from_hop)
    hops_s = cycles_s / (cycle.to_hop - cycle.from_hop).astype(cycles_s.dtype)
    return episode.where_settled(2.0 * jnp.pi / hops_s)


def _of_spectrum(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    # A gait that repeats itself with every hop peaks at the frequency of its hops, unless its
    # power is spread over harmonics. One of a longer period may peak there or below.
    known = (values["limit_cycle_period"] == 1.0) & (values["a_peak"] >= _PURE)
    return np.where(known, values["w_peak"], np.nan)


METRIC = GaitMetric(
    name="hop_rate",
    label="hop rate",
    unit="rad/s",
    about="2π times hops over time, over the cycles of CoT⁻¹",
    more_is_better=None,
    range=(0.0, float("inf")),
    shown=(TABLE, REPORT),
    otherwise=Derivation(("w_peak", "a_peak", "limit_cycle_period"), _of_spectrum),
    compute=_compute,
)
