"""Terrains: grounds whose height is a function of the place."""

from tegotae.terrains.base import Terrain
from tegotae.terrains.flat import Flat
from tegotae.terrains.rough import Rough
from tegotae.terrains.slope import Slope
from tegotae.terrains.steps import Steps
from tegotae.terrains.summed import Sum

__all__ = ["Flat", "Rough", "Slope", "Steps", "Sum", "Terrain"]
