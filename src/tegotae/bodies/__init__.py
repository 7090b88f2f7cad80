"""Bodies: the mechanics that a controller drives."""

from tegotae.bodies.bar import Bar
from tegotae.bodies.base import Body, Contact, Push, Sensation, for_limbs, require_one_limb
from tegotae.bodies.hopper import Hopper, HopperState
from tegotae.bodies.plate import Plate
from tegotae.bodies.sensors import Sensors, SensorsState
from tegotae.bodies.upright import UprightState
from tegotae.bodies.walker import Walker, WalkerState

__all__ = [
    "Bar",
    "Body",
    "Contact",
    "Hopper",
    "HopperState",
    "Plate",
    "Push",
    "Sensation",
    "Sensors",
    "SensorsState",
    "UprightState",
    "Walker",
    "WalkerState",
    "for_limbs",
    "require_one_limb",
]
