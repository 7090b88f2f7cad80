"""Bodies: the mechanics that a controller drives."""

from tegotae.parts.bodies.bar import Bar
from tegotae.parts.bodies.base import (
    Body,
    Contact,
    Interface,
    Push,
    Sensation,
    for_limbs,
    require_one_limb,
)
from tegotae.parts.bodies.hopper import Hopper, HopperState
from tegotae.parts.bodies.plate import Plate
from tegotae.parts.bodies.walker import Walker
from tegotae.parts.bodies.wrappers import Actuators, Blows, BodyWrapper, Sensors

__all__ = [
    "Actuators",
    "Bar",
    "Blows",
    "Body",
    "BodyWrapper",
    "Contact",
    "Hopper",
    "HopperState",
    "Interface",
    "Plate",
    "Push",
    "Sensation",
    "Sensors",
    "Walker",
    "for_limbs",
    "require_one_limb",
]
