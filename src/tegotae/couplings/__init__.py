"""Couplings: the only place where the limbs of a network of oscillators see each other."""

from tegotae.couplings.base import Coupling
from tegotae.couplings.learned import LearnedCoupling
from tegotae.couplings.neighbours import Neighbours

__all__ = ["Coupling", "LearnedCoupling", "Neighbours"]
