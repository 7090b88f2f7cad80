"""Terms of the controller: Action, Reaction, Gain and Actuation, vanilla and learned."""

from tegotae.terms.action import UnitAction, VanillaAction
from tegotae.terms.actuation import Actuation, LearnedActuation, Reflex, Sector, SectorAndReflex
from tegotae.terms.base import Signals, Term
from tegotae.terms.foot import EllipticFoot, LearnedFoot
from tegotae.terms.gain import ConstantGain
from tegotae.terms.network import Network
from tegotae.terms.reaction import VanillaReaction

__all__ = [
    "Actuation",
    "ConstantGain",
    "EllipticFoot",
    "LearnedActuation",
    "LearnedFoot",
    "Network",
    "Reflex",
    "Sector",
    "SectorAndReflex",
    "Signals",
    "Term",
    "UnitAction",
    "VanillaAction",
    "VanillaReaction",
]
