"""The gait laboratory: how the legs of a body go together, and what a gait's name is."""

from tegotae.measures.gaits.names import gait_of, leg_names, named
from tegotae.measures.gaits.summary import Coordination, CoordinationSummary, coordination
from tegotae.systems.legged import SYSTEMS, Legged, random_phases
from tegotae.systems.resolve import legged_system as system

__all__ = [
    "SYSTEMS",
    "Coordination",
    "CoordinationSummary",
    "Legged",
    "coordination",
    "gait_of",
    "leg_names",
    "named",
    "random_phases",
    "system",
]
