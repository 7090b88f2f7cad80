"""Terms of the controller: Action, Reaction, Gain and Actuation, vanilla and learned."""

from tegotae.parts.terms.actuation import (
    Actuation,
    LearnedActuation,
    Reflex,
    Sector,
    SectorAndReflex,
    with_vanilla_settings,
)
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.terms.feedback import (
    ConstantGain,
    OffsetAction,
    UnitAction,
    VanillaAction,
    VanillaReaction,
)
from tegotae.parts.terms.foot import CorrectedFoot, EllipticFoot, LearnedFoot, TunedFoot
from tegotae.parts.terms.network import Network
from tegotae.parts.terms.whole_body import WholeBody, WholeBodyCorrectedFoot, WholeBodyFoot

__all__ = [
    "Actuation",
    "ConstantGain",
    "CorrectedFoot",
    "EllipticFoot",
    "LearnedActuation",
    "LearnedFoot",
    "Network",
    "OffsetAction",
    "Reflex",
    "Sector",
    "SectorAndReflex",
    "Signals",
    "Term",
    "TunedFoot",
    "UnitAction",
    "VanillaAction",
    "VanillaReaction",
    "WholeBody",
    "WholeBodyCorrectedFoot",
    "WholeBodyFoot",
    "with_vanilla_settings",
]
