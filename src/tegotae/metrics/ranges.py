"""Which values the metrics of an evaluation can take at all."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from tegotae.metrics.statistics import Interval, Range, interval

_SHARE: Range = (0.0, 1.0)
_POSITIVE: Range = (0.0, math.inf)

RANGES: dict[str, Range] = {
    "cot_inverse": _POSITIVE,
    "cot_inverse_total": _POSITIVE,
    "t0_s": _POSITIVE,
    "t1_s": _POSITIVE,
    "delta_omega": (-math.inf, 0.0),
    "delta_w": _POSITIVE,
    "cpgu": _SHARE,
    "limit_cycle_period": (1.0, math.inf),
    "limit_cycle_share": _SHARE,
    "recovery_share": _SHARE,
    "failed_share": _SHARE,
    "smoothness": _POSITIVE,
    "w_peak": _POSITIVE,
    "a_peak": _SHARE,
    "optimum_share": _POSITIVE,
}
"""Least and largest possible value of each of `tegotae.evaluation.METRICS`, in its unit."""


def summarise(metrics: Mapping[str, Any], *, seed: int = 0) -> dict[str, Interval]:
    """Mean over runs of each metric, with its spread and 95 % interval within its range.

    Args:
        metrics: by name, those of `RANGES`; values of runs, shape [runs] each.
        seed: as for `interval`.

    Example:
        >>> found = summarise({"limit_cycle_share": [1.0, 1.0, 0.4]})["limit_cycle_share"]
        >>> found.low, found.high
        (0.0, 1.0)
    """
    return {
        name: interval(values, within=RANGES[name], seed=seed) for name, values in metrics.items()
    }
