"""Metrics, the paper's and users': pure functions on arrays that end in lanes, units in names."""

from tegotae.metrics.efficiency import WORK, cot_inverse, work_total
from tegotae.metrics.episode import REGIMES, ClampedEpisodes, Episode
from tegotae.metrics.gait import Gait, GaitSummary, gait
from tegotae.metrics.hopping import HOP_CLEARANCE, Hops, WholeHops, hop_height_m, hops, whole_hops
from tegotae.metrics.limit_cycle import LimitCycle, Settled, settled
from tegotae.metrics.measured import Efficiency, Measured, measure
from tegotae.metrics.metric import (
    ClampedMetric,
    Conditions,
    Derivation,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.metrics.recording import from_samples
from tegotae.metrics.registry import metrics, names, register, summarise
from tegotae.metrics.smoothness import FORCE_PERIOD_S, smoothness
from tegotae.metrics.spectrum import Spectrum, delta_omega, delta_w, peak, spectrum
from tegotae.metrics.statistics import (
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
    "Derivation",
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
