"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.studies.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.studies.generalisation.disturbance import Disturbance, Met
from tegotae.studies.generalisation.subject import Subject
from tegotae.studies.generalisation.table import margins
from tegotae.studies.generalisation.trial import Outcome, tried

__all__ = [
    "CATALOGUE",
    "Disturbance",
    "Met",
    "Outcome",
    "Subject",
    "disturbances_named",
    "margins",
    "tried",
]
