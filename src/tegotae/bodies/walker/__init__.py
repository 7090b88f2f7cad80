"""The torso that walks: its numbers, its state, its legs, and the body that they make."""

from tegotae.bodies.walker.body import Walker
from tegotae.bodies.walker.state import WalkerState

__all__ = ["Walker", "WalkerState"]
