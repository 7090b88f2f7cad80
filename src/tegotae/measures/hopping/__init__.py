"""Metrics, the paper's and users': pure functions on arrays that end in lanes, units in names."""

from tegotae.measures.hopping.gait import gait, measure
from tegotae.measures.hopping.hopping import LimitCycle
from tegotae.measures.hopping.metric import (
    REGIMES,
    ClampedEpisodes,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    Episode,
    GaitMetric,
    Metric,
)

__all__ = [
    "REGIMES",
    "ClampedEpisodes",
    "ClampedMetric",
    "Conditions",
    "DerivedMetric",
    "Episode",
    "GaitMetric",
    "LimitCycle",
    "Metric",
    "gait",
    "measure",
]
