"""Which episodes end at rest.

Source: of this library; such an episode has no limit cycle, and a CoT⁻¹ of zero.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae.measures.hopping.metric import Conditions, Derivation, DerivedMetric


def _compute(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    # Of what does not settle, a body at rest alone has a CoT⁻¹.
    rests = (values["limit_cycle_share"] == 0.0) & (values["cot_inverse"] == 0.0)
    return rests.astype(float)


METRIC = DerivedMetric(
    name="at_rest_share",
    label="at rest",
    about="share of the episodes in which the body no longer hops before it is disturbed",
    more_is_better=False,
    range=(0.0, 1.0),
    shown=(),
    derivation=Derivation(("limit_cycle_share", "cot_inverse"), _compute),
)
