"""Designs: what of a legged system's controller is learned, by names such as `ART@quadruped-c`."""

from tegotae.systems.designs.base import Family
from tegotae.systems.designs.design import Design
from tegotae.systems.designs.names import all_designs, design, is_design

__all__ = ["Design", "Family", "all_designs", "design", "is_design"]
