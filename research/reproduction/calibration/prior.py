"""The readings that are tried: a space-filling sample of what the paper leaves open of V."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from research.reproduction.readings.readings import AnalysisChoice, Reading
from tegotae._support.errors import TegotaeError, require_count

SECTOR_S = 0.02 * math.pi
"""Duration of the sector of the co-author's program [s]."""

STARTS = (1.75 * math.pi, 1.6 * math.pi)
"""Starts of the sector: the paper's (6), and the co-author's program [rad]."""

EVALUATED = (-2.0, -1.0, 0.0, 1.0, 2.0)
"""Frequencies of the evaluation relative to ω_t [rad/s]: a gain tuned over them is robust."""

PRIOR: tuple[AnalysisChoice, ...] = (
    AnalysisChoice("natural_frequency", "ωₙ √(l₀/g)", (1.8, 4.0), False, "Soft to stiff legs."),
    AnalysisChoice("damping_ratio", "ζ", (0.02, 0.4), False, "From hardly damped to one hop."),
    AnalysisChoice("force_ratio", "α / mg", (1.5, 8.0), False, "From barely enough on."),
    AnalysisChoice("mass_kg", "m", (0.03, 3.0), False, "Sets the reflex's force per feedback."),
    AnalysisChoice("rest_length_m", "l₀", (0.25, 2.0), False, "Sets gravity's rate beside ω."),
    AnalysisChoice("release", "release / l₀", (1.0, 1.3), False, "As of the multiverse."),
    AnalysisChoice("flight_damping", "damping in flight", (0.0, 1.0), True, "Paper, or program."),
    AnalysisChoice("sector_start", "sector from", STARTS, True, "The same."),
    AnalysisChoice(
        "sector_s", "sector's duration", (None, SECTOR_S), True, "In phase, or in time."
    ),
    AnalysisChoice("work", "work", ("net", "positive", "absolute"), True, "As of the multiverse."),
    AnalysisChoice(
        "frequency_weight", "weight of ΔΩ", (0.005, 1.0), False, "Hz² is 0.025, rad²/s² is 1."
    ),
    AnalysisChoice(
        "tuned_over", "V's σ tuned at", ((0.0,), EVALUATED), True, "ω_t, or all evaluated ω."
    ),
)
"""Choices and their ranges. The reflex's force per feedback stays at the paper's 1: with another
mass, and another weight of ΔΩ, it is the same loop."""

LOGARITHMIC = ("mass_kg", "rest_length_m", "frequency_weight")
"""Choices that are tried evenly in their logarithms."""

_SEED = 1


def candidates(count: int) -> list[Reading]:
    """Return a number of readings that their bodies allow: points of a scrambled Sobol sequence.

    More of them add to those that were there.

    Raises:
        TegotaeError: for a count below one.

    Example:
        >>> candidates(3) == candidates(5)[:3]
        True
    """
    from scipy.stats import qmc  # slow to import

    require_count("bodies", count)
    readings: list[Reading] = []
    exponent = max(count - 1, 1).bit_length()
    while len(readings) < count:
        # A longer sequence begins as the shorter one does.
        points = qmc.Sobol(len(PRIOR), rng=_SEED).random_base2(exponent)
        readings = [reading for reading in map(_reading, points) if reading is not None]
        exponent += 1
    return readings[:count]


def coordinates(reading: Reading) -> np.ndarray:
    """Return a reading's position in the prior, each choice from 0 to 1, [choices]."""
    return np.array([relative_place(choice, getattr(reading, choice.name)) for choice in PRIOR])


def relative_place(choice: AnalysisChoice, value: Any) -> float:
    """Return a value's position between the ends of a choice, from 0 to 1."""
    if choice.name in LOGARITHMIC:
        low, high = choice.values
        return math.log(value / low) / math.log(high / low)
    return choice.place(value)


def value_at(choice: AnalysisChoice, share: float) -> Any:
    """Return the value at a share in [0, 1) of the way between the ends of a choice."""
    if choice.name in LOGARITHMIC:
        low, high = choice.values
        return low * (high / low) ** share
    return choice.value_at(share)


def _reading(point: np.ndarray) -> Reading | None:
    values: dict[str, Any] = {}
    for choice, share in zip(PRIOR, point, strict=True):
        value = value_at(choice, float(share))
        # Numbers that a table holds, and a person can copy.
        continuous = isinstance(value, float) and not choice.levels
        values[choice.name] = float(f"{value:.4g}") if continuous else value
    try:
        return Reading(**values)
    except TegotaeError:
        return None  # a body that cannot stand, or whose leg is pressed to nothing
