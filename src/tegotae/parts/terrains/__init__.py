"""Terrains: grounds whose height is a function of the place."""

from tegotae.parts.terrains.base import Terrain
from tegotae.parts.terrains.flat import Flat
from tegotae.parts.terrains.rough import Rough
from tegotae.parts.terrains.slope import Slope
from tegotae.parts.terrains.steps import Steps
from tegotae.parts.terrains.summed import Sum

__all__ = ["Flat", "Rough", "Slope", "Steps", "Sum", "Terrain"]
