"""`tegotae figure portrait`: where a gait goes from several releases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae.cli.figure.policy import PolicySubject


@dataclass(frozen=True, kw_only=True)
class Portrait(PolicySubject):
    """Phase portraits of a controller or a policy: (y, ẏ), and spring force over phase."""

    heights: tuple[float, ...] = (1.05, 1.2, 1.6)
    """Release heights, at rest [m]; without --height."""
    duration: float = 30.0
    """Simulated time [s]."""

    def run(self) -> None:
        """Simulate and draw."""
        from tegotae.analysis.orbit import paths_of
        from tegotae.figures.cycles import portrait_figure, portrait_table

        self.check_out()
        heights = np.array(self.heights if self.height is None else (self.height,))
        driven = self.loaded() or self.saved()
        if self.policy is None:
            paths = paths_of(driven, heights, duration_s=self.duration)
        else:
            from tegotae.analysis.policy import policy_paths

            phase_rad = self.released[1]
            paths = policy_paths(driven, heights, phase_rad=phase_rad, duration_s=self.duration)
        rest_length_m = float(self.hopper_of(driven).rest_length_m)
        figure = portrait_figure(paths, rest_length_m=rest_length_m, note=self.title(driven))
        self.write(figure, {"": portrait_table(paths)})
