"""Which episodes settle.

Source: of this library; the paper (IV-A) asks of every episode whether a limit cycle forms.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.episode import LIMIT_CYCLE
from tegotae.measures.hopping.metric import (
    REGIME,
    Conditions,
    Derivation,
    DerivedMetric,
)


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    return (values[REGIME] == LIMIT_CYCLE).astype(float)


METRIC = DerivedMetric(
    name="limit_cycle_share",
    label="limit cycles",
    about="share of the episodes with a limit cycle",
    more_is_better=True,
    range=(0.0, 1.0),
    derivation=Derivation((REGIME,), _compute),
)
