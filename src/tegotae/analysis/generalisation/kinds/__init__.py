"""Kinds of disturbances: by what of scenario or body they are made."""

from tegotae.analysis.generalisation.kinds.blows import Blow, ForcePulse, LostLeg
from tegotae.analysis.generalisation.kinds.body import Frequency, Scaled
from tegotae.analysis.generalisation.kinds.ground import (
    Ground,
    Incline,
    ReleaseHeight,
    Roughness,
    Stairs,
)
from tegotae.analysis.generalisation.kinds.signals import Late, Noise, Strength

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
