"""How near a gait comes to what is physically possible.

Source: of this library (`tegotae.measures.optimum`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.metric import Conditions, Derivation, DerivedMetric
from tegotae.measures.optimum import has_table, share


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    cot, rate = values["cot_inverse"], values["hop_rate"]
    if not has_table(conditions.body, conditions.work):
        return np.full(np.shape(cot), np.nan)
    return share(cot, rate, values["limit_cycle_period"])


METRIC = DerivedMetric(
    name="optimum_share",
    label="of optimum",
    about="CoT⁻¹ over the largest that any force can have at the gait's own hop rate",
    more_is_better=True,
    range=(0.0, float("inf")),
    derivation=Derivation(("cot_inverse", "hop_rate", "limit_cycle_period"), _compute),
)
