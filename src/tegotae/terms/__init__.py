"""Terms of the controller: Action, Reaction, Gain and Actuation, vanilla and learned."""

from tegotae.terms.action import OffsetAction, UnitAction, VanillaAction
from tegotae.terms.actuation import Actuation, LearnedActuation, Reflex, Sector, SectorAndReflex
from tegotae.terms.base import Signals, Term
from tegotae.terms.foot import CorrectedFoot, EllipticFoot, LearnedFoot
from tegotae.terms.gain import ConstantGain
from tegotae.terms.network import Network
from tegotae.terms.reaction import VanillaReaction
from tegotae.terms.whole_body import WholeBody, WholeBodyFoot

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
    "UnitAction",
    "VanillaAction",
    "VanillaReaction",
    "WholeBody",
    "WholeBodyFoot",
]
