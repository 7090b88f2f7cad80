"""The kept fronts of legged systems: the least cost of transport found at each speed."""

from tegotae.measures.fronts.table import SpeedFront, front, front_table

__all__ = ["SpeedFront", "front", "front_table"]
