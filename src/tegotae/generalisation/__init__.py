"""What trained controllers do, unchanged, in conditions that they were not trained in."""

from tegotae.generalisation.catalogue import CATALOGUE, disturbances_named
from tegotae.generalisation.disturbance import Disturbance, Met
from tegotae.generalisation.subject import Subject
from tegotae.generalisation.table import margins
from tegotae.generalisation.trial import Outcome, tried

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
