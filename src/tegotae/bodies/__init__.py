"""Bodies: the mechanics that a controller drives."""

from tegotae.bodies.bar import Bar, BarState
from tegotae.bodies.base import Body, Contact, Push, Sensation, require_one_limb
from tegotae.bodies.hopper import Hopper, HopperState
from tegotae.bodies.walker import Walker, WalkerState

__all__ = [
    "Bar",
    "BarState",
    "Body",
    "Contact",
    "Hopper",
    "HopperState",
    "Push",
    "Sensation",
    "Walker",
    "WalkerState",
    "require_one_limb",
]
