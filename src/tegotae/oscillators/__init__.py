"""Oscillators: the rhythm that Tegotae feedback entrains."""

from tegotae.oscillators.base import Oscillator
from tegotae.oscillators.phase import ClampedPhase, PhaseOscillator, PhaseState

__all__ = ["ClampedPhase", "Oscillator", "PhaseOscillator", "PhaseState"]
