"""Oscillators: the rhythm generators of decentralised control, and their names in models."""

from tegotae._support.errors import lookup
from tegotae.parts.oscillators.base import (
    Oscillator as Oscillator,
    PhaseOscillator as PhaseOscillator,
    PhaseState as PhaseState,
)
from tegotae.parts.oscillators.foothold import (
    FootholdOscillator as FootholdOscillator,
    raibert_placement as raibert_placement,
)
from tegotae.parts.oscillators.matsuoka import Matsuoka as Matsuoka
from tegotae.parts.oscillators.planar import (
    AdaptiveHopf as AdaptiveHopf,
    Hopf as Hopf,
    Planar,
    VanDerPol as VanDerPol,
)
from tegotae.parts.oscillators.wary import WaryOscillator as WaryOscillator
from tegotae.parts.oscillators.wrappers import Clamped as Clamped, Learned as Learned

PHASE = "phase"
"""The paper's oscillator."""

PLANAR: dict[str, Planar] = {
    "hopf": Hopf(),
    "adaptive-hopf": AdaptiveHopf(),
    "van-der-pol": VanDerPol(),
    "matsuoka": Matsuoka(),
}
"""Those that turn in a plane, with parameters as given."""

OSCILLATORS: dict[str, Oscillator] = {
    PHASE: PhaseOscillator(),
    **PLANAR,
    **{f"learned-{name}": Learned(oscillator) for name, oscillator in PLANAR.items()},
}
"""Each with parameters as given, and, but for the paper's, with trained ones."""


def oscillator_named(name: str) -> Oscillator:
    """Return the oscillator of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> oscillator_named("learned-van-der-pol").n_weights
        4
    """
    return lookup("oscillator", name, OSCILLATORS)
