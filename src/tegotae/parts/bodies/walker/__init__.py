"""The torso that walks: its numbers, its state, its legs, and the body that they make."""

from tegotae.parts.bodies.walker.body import Walker as Walker
from tegotae.parts.bodies.walker.mechanics import WalkerState as WalkerState
