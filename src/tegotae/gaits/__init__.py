"""The gait laboratory: how the legs of a body go together, and what a gait's name is."""

from tegotae.gaits.legged import Legged, random_phases
from tegotae.gaits.names import gait_of, named
from tegotae.gaits.places import leg_names
from tegotae.gaits.summary import Coordination, CoordinationSummary, coordination
from tegotae.gaits.systems import SYSTEMS, system

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
