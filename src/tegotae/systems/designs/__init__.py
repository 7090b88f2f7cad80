"""Designs: what of a legged system's controller is learned, by names such as `ART@quadruped-c`."""

from tegotae.systems.designs.base import Family
from tegotae.systems.designs.design import Design, all_designs, design, is_design

__all__ = ["Design", "Family", "all_designs", "design", "is_design"]
