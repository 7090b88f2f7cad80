"""Bodies: the mechanics that a controller drives."""

from tegotae.bodies.bar import Bar
from tegotae.bodies.base import Body, Contact, Push, Sensation, require_one_limb
from tegotae.bodies.hopper import Hopper, HopperState
from tegotae.bodies.plate import Plate
from tegotae.bodies.upright import UprightState

__all__ = [
    "Bar",
    "Body",
    "Contact",
    "Hopper",
    "HopperState",
    "Plate",
    "Push",
    "Sensation",
    "UprightState",
    "require_one_limb",
]
