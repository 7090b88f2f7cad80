"""Named settings of hopper, oscillator and release."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from tegotae._support.errors import unknown
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import Oscillator, PhaseOscillator
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    Reflex,
    Sector,
    SectorAndReflex,
    VanillaAction,
    VanillaReaction,
)

PAPERS = PhaseOscillator()
"""The paper's oscillator."""


@dataclass(frozen=True, kw_only=True)
class Preset:
    """A hopper, its vanilla controller's numbers, and how it is released."""

    about: str
    """One line on where the numbers come from."""
    hopper: Hopper = field(default_factory=Hopper)
    sector: Sector = field(default_factory=Sector)
    actuation: str = "sector"
    """The actuation that the preset stands for: "sector", "reflex" or "both"."""
    omega_rad_per_s: float = 5.0
    """Frequency ω [rad/s]."""
    sigma: float = 2.753
    """Gain σ [rad/(s N)]."""
    height_m: float = 1.2
    """Release height [m], at rest."""

    def controller(self, actuation: str, oscillator: Oscillator = PAPERS) -> Controller:
        """The vanilla controller with this actuation: "sector", "reflex" or "both".

        Args:
            actuation: its name.
            oscillator: the paper's by default.

        Raises:
            TegotaeError: for another actuation.
        """
        sector = self.sector
        known: dict[str, Actuation] = {
            "sector": sector,
            "reflex": Reflex(),
            "both": SectorAndReflex(sector.start_rad, sector.width_rad, sector.duration_s),
        }
        if actuation not in known:
            raise unknown("actuation", actuation, known)
        terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        return Controller(known[actuation], oscillator, terms)


PRESETS: dict[str, Preset] = {
    "paper": Preset(
        about="the paper's hopper; numbers from its co-author's program, the paper prints none"
    ),
    "pyTegotaeCPG": Preset(
        about="the exact rules of the program daiowaki1229/pyTegotaeCPG (2025): damping in flight "
        "too, a sector from 1.6π of width 0.02·ω·π, released at the rest length",
        hopper=Hopper(flight_damping_ns_per_m=0.2),
        sector=Sector(start_rad=1.6 * math.pi, width_rad=0.0, duration_s=0.02 * math.pi),
        height_m=1.0,
    ),
}


def preset(name: str) -> Preset:
    """The preset of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.
    """
    if name not in PRESETS:
        raise unknown("preset", name, PRESETS)
    return PRESETS[name]
