"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.studies.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.studies.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.studies.generalisation.disturbance import Disturbance
from tegotae.studies.generalisation.table import margins
from tegotae.studies.generalisation.trial import Retention, tried

__all__ = [
    "CATALOGUE",
    "ControllersUnderTest",
    "Disturbance",
    "Retention",
    "disturbances_named",
    "margins",
    "tried",
]
