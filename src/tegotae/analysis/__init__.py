"""Computations behind the figures: from a controller to arrays, without drawing."""

from tegotae.analysis.gain_sweep import GainSweep, gain_sweep
from tegotae.analysis.outcome import Outcome, OutcomeSummary
from tegotae.analysis.ridge import Ridge, one_to_one_ridge, ridge
from tegotae.analysis.sweep import axis

__all__ = [
    "GainSweep",
    "Outcome",
    "OutcomeSummary",
    "Ridge",
    "axis",
    "gain_sweep",
    "one_to_one_ridge",
    "ridge",
]
