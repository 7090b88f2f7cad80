"""Oscillators: the rhythm generators of decentralised control."""

from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.oscillators.hopf import (
    AdaptiveHopf,
    AdaptiveState,
    Hopf,
    HopfState,
)
from tegotae.parts.oscillators.matsuoka import Matsuoka, MatsuokaState
from tegotae.parts.oscillators.named import OSCILLATORS, oscillator_named
from tegotae.parts.oscillators.phase import PhaseOscillator, PhaseState
from tegotae.parts.oscillators.van_der_pol import VanDerPol, VanDerPolState
from tegotae.parts.oscillators.wrappers import Clamped, Learned

__all__ = [
    "OSCILLATORS",
    "AdaptiveHopf",
    "AdaptiveState",
    "Clamped",
    "Hopf",
    "HopfState",
    "Learned",
    "Matsuoka",
    "MatsuokaState",
    "Oscillator",
    "PhaseOscillator",
    "PhaseState",
    "VanDerPol",
    "VanDerPolState",
    "oscillator_named",
]
