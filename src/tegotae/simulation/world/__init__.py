"""What a lane meets: release, frequency, ground, and what changes on the way. All of it is data."""

from tegotae.simulation.world.scenario import (
    Change,
    Condition,
    OneOf,
    Scenario,
    Staircase,
    Step,
    Uniform,
    apply_changes,
    ground_m,
    map_change,
    whole_run,
    with_changes,
)

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
