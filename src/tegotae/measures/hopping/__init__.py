"""Metrics of hopping: pure functions on arrays that end in lanes, units in names."""

from tegotae.measures.hopping.gait import gait as gait, measure as measure
from tegotae.measures.hopping.hopping import LimitCycle as LimitCycle
from tegotae.measures.hopping.metrics import (
    HOPPING as HOPPING,
    REGIMES as REGIMES,
    ClampedEpisodes as ClampedEpisodes,
    ClampedMetric as ClampedMetric,
    Conditions as Conditions,
    DerivedMetric as DerivedMetric,
    Episode as Episode,
    GaitMetric as GaitMetric,
)
