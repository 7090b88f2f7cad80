"""Oscillators: the rhythm generators of decentralised control."""

from tegotae.oscillators.base import Oscillator
from tegotae.oscillators.clamped import Clamped
from tegotae.oscillators.hopf import AdaptiveHopf, AdaptiveState, Hopf, HopfState
from tegotae.oscillators.learned import Learned
from tegotae.oscillators.matsuoka import Matsuoka, MatsuokaState
from tegotae.oscillators.named import OSCILLATORS, oscillator_named
from tegotae.oscillators.phase import PhaseOscillator, PhaseState
from tegotae.oscillators.van_der_pol import VanDerPol, VanDerPolState

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
