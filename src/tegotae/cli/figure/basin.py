"""`tegotae figure basin`: which release ends in which limit cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tegotae._support.limits import MOST_M
from tegotae.cli.figure.subject import Subject
from tegotae.simulation.rollout import Timing


@dataclass(frozen=True, kw_only=True)
class Basin(Subject):
    """Basins of attraction: which release height and phase end in which limit cycle, or none."""

    height: tuple[float, float] = (0.4, 2.5)
    """Range of the release height [m]."""
    velocity: tuple[float, float] = (-4.0, 4.0)
    """Range of the release velocity, which takes the phase's place without oscillator [m/s]."""
    resolution: int = 60
    """Points along either axis."""
    duration: float = 40.0
    """Simulated time; what has not settled by its end has no limit cycle [s]."""

    def run(self) -> None:
        """Compute, write, and list the limit cycles."""
        from tegotae.figures.basin import basin_figure, basin_tables, describe
        from tegotae.studies.analysis import axis, map_basin

        self.check_out()
        saved = self.saved()
        heights = axis("height", *self.height, self.resolution, above=0.0, most=MOST_M)
        across = (
            axis("velocity", *self.velocity, self.resolution, most=MOST_M)
            if saved.controller.oscillator is None
            else axis("phase", 0.0, 2.0 * math.pi, self.resolution)
        )
        found = map_basin(saved, heights, across, timing=Timing(duration_s=self.duration))
        for attractor in found.attractors:
            print(f"{describe(attractor)}, CoT⁻¹ {attractor.cot_inverse:.3f} m/J")
        without = 1.0 - sum(attractor.share for attractor in found.attractors)
        print(f"no limit cycle: {without:.1%} of the releases")
        self.write(basin_figure(found, self.title(saved)), basin_tables(found))
