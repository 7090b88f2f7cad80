"""Oscillators: the rhythm generators of decentralised control."""

from tegotae.oscillators.base import Oscillator
from tegotae.oscillators.clamped import Clamped
from tegotae.oscillators.phase import PhaseOscillator, PhaseState

__all__ = ["Clamped", "Oscillator", "PhaseOscillator", "PhaseState"]
