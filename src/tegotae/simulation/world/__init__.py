"""What a lane meets: release, frequency, ground, and what changes on the way. All of it is data."""

from tegotae.simulation.world.changes import (
    Change,
    Staircase,
    Step,
    apply_changes,
    map_change,
    whole_run,
    with_changes,
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
    "apply_changes",
    "ground_m",
    "map_change",
    "whole_run",
    "with_changes",
]
