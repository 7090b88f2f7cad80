"""Which episodes end in a failure.

Source: of this library.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.episode import FAILED
from tegotae.measures.hopping.metric import (
    REGIME,
    Conditions,
    Derivation,
    DerivedMetric,
)


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    return (values[REGIME] == FAILED).astype(float)


METRIC = DerivedMetric(
    name="failed_share",
    label="failed",
    about="share of the episodes in which the body fails before it is disturbed",
    more_is_better=False,
    range=(0.0, 1.0),
    shown=(),
    derivation=Derivation((REGIME,), _compute),
)
