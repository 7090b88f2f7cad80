"""Kinds of disturbances: by what of scenario or body they are made."""

from tegotae.studies.generalisation.kinds.blows import Blow, ForcePulse, LostLeg
from tegotae.studies.generalisation.kinds.body import Frequency, Scaled
from tegotae.studies.generalisation.kinds.ground import (
    Ground,
    Incline,
    ReleaseHeight,
    Roughness,
    Stairs,
)
from tegotae.studies.generalisation.kinds.signals import Late, Noise, Strength

__all__ = [
    "Blow",
    "ForcePulse",
    "Frequency",
    "Ground",
    "Incline",
    "Late",
    "LostLeg",
    "Noise",
    "ReleaseHeight",
    "Roughness",
    "Scaled",
    "Stairs",
    "Strength",
]
