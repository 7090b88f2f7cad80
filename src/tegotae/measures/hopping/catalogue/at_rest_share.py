"""Which episodes end at rest.

Source: of this library; such an episode has no limit cycle, and a CoT⁻¹ of zero.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.episode import AT_REST
from tegotae.measures.hopping.metric import (
    REGIME,
    Conditions,
    Derivation,
    DerivedMetric,
)


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    return (values[REGIME] == AT_REST).astype(float)


METRIC = DerivedMetric(
    name="at_rest_share",
    label="at rest",
    about="share of the episodes in which the body no longer hops before it is disturbed",
    more_is_better=False,
    range=(0.0, 1.0),
    shown=(),
    derivation=Derivation((REGIME,), _compute),
)
