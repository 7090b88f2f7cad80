"""Metrics, the paper's and users': pure functions on arrays that end in lanes, units in names."""

from tegotae.measures.hopping.episode import REGIMES, ClampedEpisodes, Episode
from tegotae.measures.hopping.gait import Gait, GaitSummary, gait
from tegotae.measures.hopping.hopping import (
    HOP_CLEARANCE,
    Hops,
    WholeHops,
    hop_height_m,
    hops,
    whole_hops,
)
from tegotae.measures.hopping.limit_cycle import LimitCycle, Settled, settled
from tegotae.measures.hopping.measured import Efficiency, Measured, measure
from tegotae.measures.hopping.metric import (
    ClampedMetric,
    Conditions,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.hopping.registry import (
    metrics,
    names,
    register,
    summarise,
)
from tegotae.measures.hopping.signals import (
    FORCE_PERIOD_S,
    WORK,
    Spectrum,
    cot_inverse,
    delta_omega,
    delta_w,
    peak,
    smoothness,
    spectrum,
    work_total,
)
from tegotae.measures.hopping.statistics import (
    Interval,
    balanced_difference,
    difference,
    interval,
    paired_difference,
    stratified_difference,
)

__all__ = [
    "FORCE_PERIOD_S",
    "HOP_CLEARANCE",
    "REGIMES",
    "WORK",
    "ClampedEpisodes",
    "ClampedMetric",
    "Conditions",
    "DerivedMetric",
    "Efficiency",
    "Episode",
    "Gait",
    "GaitMetric",
    "GaitSummary",
    "Hops",
    "Interval",
    "LimitCycle",
    "Measured",
    "Metric",
    "Settled",
    "Spectrum",
    "WholeHops",
    "balanced_difference",
    "cot_inverse",
    "delta_omega",
    "delta_w",
    "difference",
    "from_samples",
    "gait",
    "hop_height_m",
    "hops",
    "interval",
    "measure",
    "metrics",
    "names",
    "paired_difference",
    "peak",
    "register",
    "settled",
    "smoothness",
    "spectrum",
    "stratified_difference",
    "summarise",
    "whole_hops",
    "work_total",
]
