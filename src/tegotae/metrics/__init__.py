"""The paper's metrics, as pure functions on arrays: shapes end in lanes, units are in the names."""

from tegotae.metrics.efficiency import WORK, cot_inverse, work_total
from tegotae.metrics.gait import REGIMES, Gait, GaitSummary, gait, measure
from tegotae.metrics.hopping import HOP_CLEARANCE, Hops, hop_height_m, hops
from tegotae.metrics.limit_cycle import LimitCycle, Settled, settled
from tegotae.metrics.ranges import RANGES, summarise
from tegotae.metrics.recording import from_samples
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
    "RANGES",
    "REGIMES",
    "WORK",
    "Gait",
    "GaitSummary",
    "Hops",
    "Interval",
    "LimitCycle",
    "Settled",
    "Spectrum",
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
    "paired_difference",
    "peak",
    "settled",
    "smoothness",
    "spectrum",
    "stratified_difference",
    "summarise",
    "work_total",
]
