"""What a lane meets: release, frequency, ground, and what changes on the way. All of it is data."""

from tegotae.simulation.world.changes import (
    Change,
    Staircase,
    Step,
    map_change,
    met_by,
    whole_run,
)
from tegotae.simulation.world.conditions import Condition, OneOf, Uniform
from tegotae.simulation.world.scenario import Scenario, ground_m

__all__ = [
    "Change",
    "Condition",
    "OneOf",
    "Scenario",
    "Staircase",
    "Step",
    "Uniform",
    "ground_m",
    "map_change",
    "met_by",
    "whole_run",
]
