"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.analysis.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.analysis.generalisation.disturbance import Disturbance, Tested
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import Retention, margins, tried

__all__ = [
    "CATALOGUE",
    "ControllersUnderTest",
    "Disturbance",
    "Retention",
    "Tested",
    "disturbances_named",
    "margins",
    "tried",
]
