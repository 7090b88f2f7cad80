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
from tegotae.parts.bodies.upright import UprightState
from tegotae.parts.bodies.walker import Walker, WalkerState
from tegotae.parts.bodies.wrappers import (
    Actuators,
    ActuatorsState,
    Blows,
    BlowsState,
    BodyWrapper,
    Sensors,
    SensorsState,
)

__all__ = [
    "Actuators",
    "ActuatorsState",
    "Bar",
    "Blows",
    "BlowsState",
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
    "SensorsState",
    "UprightState",
    "Walker",
    "WalkerState",
    "for_limbs",
    "require_one_limb",
]
