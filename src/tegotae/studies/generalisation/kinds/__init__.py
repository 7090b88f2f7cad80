"""Kinds of disturbances: by what of scenario or body they are made."""

from tegotae.studies.generalisation.kinds.blows import Blow, LostLeg, Push
from tegotae.studies.generalisation.kinds.body import Frequency, Scaled
from tegotae.studies.generalisation.kinds.ground import (
    Ground,
    Incline,
    Release,
    Roughness,
    Stairs,
)
from tegotae.studies.generalisation.kinds.signals import Late, Noise, Strength

__all__ = [
    "Blow",
    "Frequency",
    "Ground",
    "Incline",
    "Late",
    "LostLeg",
    "Noise",
    "Push",
    "Release",
    "Roughness",
    "Scaled",
    "Stairs",
    "Strength",
]
