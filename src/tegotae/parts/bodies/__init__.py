"""Bodies: the mechanics that a controller drives."""

from tegotae.parts.bodies.base import (
    Body as Body,
    Contact as Contact,
    Interface as Interface,
    Push as Push,
    Sensation as Sensation,
    for_limbs as for_limbs,
    require_one_limb as require_one_limb,
)
from tegotae.parts.bodies.hopper import Hopper as Hopper, HopperState as HopperState
from tegotae.parts.bodies.rigid import Bar as Bar, Plate as Plate
from tegotae.parts.bodies.walker import Walker as Walker
from tegotae.parts.bodies.wrappers import (
    Actuators as Actuators,
    Blows as Blows,
    BodyWrapper as BodyWrapper,
    Pushes as Pushes,
    Sensors as Sensors,
)
