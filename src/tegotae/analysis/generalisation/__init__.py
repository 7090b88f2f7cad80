"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.analysis.generalisation.disturbances import (
    CATALOGUE,
    Disturbance,
    Tested,
    disturbances_named,
)
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
