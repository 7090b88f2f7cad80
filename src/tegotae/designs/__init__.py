"""Designs: what of a legged system's controller is learned, by names such as `ART@quadruped-c`."""

from tegotae.designs.base import Family
from tegotae.designs.design import Design
from tegotae.designs.names import all_designs, design, is_design

__all__ = ["Design", "Family", "all_designs", "design", "is_design"]
