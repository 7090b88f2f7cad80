"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.studies.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.studies.generalisation.disturbance import Disturbance
from tegotae.studies.generalisation.table import margins
from tegotae.studies.generalisation.tested_controllers import TestedControllers
from tegotae.studies.generalisation.trial import Retention, tried

__all__ = [
    "CATALOGUE",
    "Disturbance",
    "Retention",
    "TestedControllers",
    "disturbances_named",
    "margins",
    "tried",
]
