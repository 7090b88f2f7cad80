"""The basin of one leg, for `tegotae figure basin`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tegotae._support.limits import MOST_M
from tegotae.systems.controller_file import SavedController

if TYPE_CHECKING:
    from tegotae.analysis.maps import HopperBasin

DURATION_S = 40.0
"""Simulated time by default [s]."""


def find_basin(
    saved: SavedController,
    height: tuple[float, float],
    velocity: tuple[float, float],
    resolution: int,
    duration_s: float | None,
) -> HopperBasin:
    """Release a hopper from all heights of a range, at all phases or velocities, and print where
    it ends.

    Raises:
        TegotaeError: for a range or a resolution that is none.
    """
    from tegotae.analysis.maps import axis, map_basin
    from tegotae.figures.maps import describe

    heights = axis("height", *height, resolution, above=0.0, most=MOST_M)
    across = (
        axis("velocity", *velocity, resolution, most=MOST_M)
        if saved.controller.oscillator is None
        else axis("phase", 0.0, 2.0 * math.pi, resolution)
    )
    timing = saved.system.timing_over(DURATION_S if duration_s is None else duration_s)
    found = map_basin(saved, heights, across, timing=timing)
    for attractor in found.attractors:
        print(f"{describe(attractor)}, CoT⁻¹ {attractor.cot_inverse:.3f} m/J")
    without = 1.0 - sum(attractor.share for attractor in found.attractors)
    print(f"no limit cycle: {without:.1%} of the releases")
    return found
