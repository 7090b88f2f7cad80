"""Which settled episodes settle again after the ground dropped.

Source: paper IV-A, on T1: "new limit cycle formation, if any".
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.metric import Conditions, Derivation, DerivedMetric


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    tested = (values["limit_cycle_share"] == 1.0) & (conditions.drop_m > 0.0)
    return np.where(tested, np.isfinite(values["t1_s"]), np.nan)


METRIC = DerivedMetric(
    name="recovery_share",
    label="recovers",
    about="share of the settled episodes that settle again after a drop of the ground",
    more_is_better=True,
    range=(0.0, 1.0),
    shown=(),
    derivation=Derivation(("limit_cycle_share", "t1_s"), _compute),
)
