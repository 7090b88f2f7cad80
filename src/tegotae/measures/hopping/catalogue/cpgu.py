"""CPGu, how much a gait needs its oscillator.

Source: paper IV-A.
"""

from __future__ import annotations

import numpy as np

from tegotae.measures.hopping.episode import ClampedEpisodes
from tegotae.measures.hopping.metric import ClampedMetric


def _compute(clamped: ClampedEpisodes) -> np.ndarray:
    return 1.0 - clamped.on_cycle.mean(axis=-1)


METRIC = ClampedMetric(
    name="cpgu",
    label="CPGu",
    about="share of clamped phases without a limit cycle: 1 depends fully on the oscillator",
    more_is_better=None,
    range=(0.0, 1.0),
    compute=_compute,
)
