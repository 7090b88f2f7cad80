"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.analysis.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.run import margins
from tegotae.analysis.generalisation.trial import Retention, tried

__all__ = [
    "CATALOGUE",
    "ControllersUnderTest",
    "Disturbance",
    "Retention",
    "disturbances_named",
    "margins",
    "tried",
]
