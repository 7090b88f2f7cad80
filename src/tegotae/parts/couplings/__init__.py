"""Couplings: the only place where the limbs of a network of oscillators see each other."""

from tegotae.parts.couplings.base import Coupling
from tegotae.parts.couplings.learned import LearnedCoupling
from tegotae.parts.couplings.neighbours import Neighbours

__all__ = ["Coupling", "LearnedCoupling", "Neighbours"]
