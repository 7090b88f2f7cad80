"""Bodies: the mechanics that a controller drives."""

from tegotae.bodies.actuators import Actuators, ActuatorsState
from tegotae.bodies.around import Around
from tegotae.bodies.bar import Bar
from tegotae.bodies.base import Body, Contact, Push, Sensation, for_limbs, require_one_limb
from tegotae.bodies.blows import Blows, BlowsState
from tegotae.bodies.hopper import Hopper, HopperState
from tegotae.bodies.plate import Plate
from tegotae.bodies.sensors import Sensors, SensorsState
from tegotae.bodies.upright import UprightState
from tegotae.bodies.walker import Walker, WalkerState
from tegotae.bodies.wired import WiredLimbs

__all__ = [
    "Actuators",
    "ActuatorsState",
    "Around",
    "Bar",
    "Blows",
    "BlowsState",
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
    "WiredLimbs",
    "for_limbs",
    "require_one_limb",
]
