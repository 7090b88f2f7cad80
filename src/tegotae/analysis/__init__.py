"""Computations behind the figures: from a controller to arrays, without drawing."""

from tegotae.analysis.basin import Attractor, HopperBasin, map_basin
from tegotae.analysis.orbit import NoLimitCycleError, Orbit, Paths, find_orbit, paths_of
from tegotae.analysis.phase_response import PhaseResponse, measure_phase_response
from tegotae.analysis.poincare import Poincare, poincare_section, transient
from tegotae.analysis.ridge import (
    DetuningLoss,
    GainSweep,
    Resonance,
    Ridge,
    find_losses,
    find_resonance,
    find_ridge,
    one_to_one_ridge,
    sweep_gain,
)
from tegotae.analysis.surface import Surface, actuation_surface, sees_velocity
from tegotae.analysis.sweep import Outcome, OutcomeSummary, axis, locking_ratios

__all__ = [
    "Attractor",
    "DetuningLoss",
    "GainSweep",
    "HopperBasin",
    "NoLimitCycleError",
    "Orbit",
    "Outcome",
    "OutcomeSummary",
    "Paths",
    "PhaseResponse",
    "Poincare",
    "Resonance",
    "Ridge",
    "Surface",
    "actuation_surface",
    "axis",
    "find_losses",
    "find_orbit",
    "find_resonance",
    "find_ridge",
    "locking_ratios",
    "map_basin",
    "measure_phase_response",
    "one_to_one_ridge",
    "paths_of",
    "poincare_section",
    "sees_velocity",
    "sweep_gain",
    "transient",
]
