"""`tegotae figure basin`: where releases end: in which limit cycle, or in which gait."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tegotae.cli.figure.controller import ControllerFigure
from tegotae.cli.gait.options import OF_LEGS, LegsOptions, legs_of
from tegotae.cli.options import UNSET, refuse_given, require_ours
from tegotae.systems.resolve import Resolved, resolve

OF_ONE_LEG = ("height", "velocity", "resolution", "actuation", "oscillator", "preset")


@dataclass(frozen=True, kw_only=True)
class Basin(LegsOptions, ControllerFigure):
    """Basins of attraction. One leg: the limit cycle for each release height and phase; several
    legs: the gaits that emerge from random phases, how often, and how soon.
    """

    height: tuple[float, float] = (0.4, 2.5)
    """Range of the release height [m], for one leg."""
    velocity: tuple[float, float] = (-4.0, 4.0)
    """Range of the release velocity [m/s]; replaces the phase without an oscillator."""
    resolution: int = 60
    """Points along either axis, for one leg."""
    starts: int = 256
    """Number of releases, for several legs."""
    duration: Annotated[float | None, UNSET] = None
    """Simulated time [s]; by default 40 s for one leg, and the system's for several."""

    def run(self) -> None:
        """Compute, write, and print."""
        found = None if self.path is None else resolve(self.path)
        if found is not None:
            require_ours(found)
        if found is not None and found.body.limbs > 1:
            refuse_given(self, OF_ONE_LEG, found.name, several=True)
            self._of_several(found)
        else:
            name = "a vanilla controller" if found is None else found.name
            refuse_given(self, (*OF_LEGS, "starts"), name, several=False)
            self._of_one_leg(found)

    def _of_one_leg(self, found: Resolved | None) -> None:
        from tegotae.cli.hopping import find_basin
        from tegotae.figures.maps import basin_figure, basin_tables

        self.check_out()
        saved = self.vanilla() if found is None else self.adapted(found)
        basin = find_basin(saved, self.height, self.velocity, self.resolution, self.duration)
        self.write(basin_figure(basin, self.title(saved)), basin_tables(basin))

    def _of_several(self, found: Resolved) -> None:
        from tegotae.cli.walking import draw_basin

        draw_basin(legs_of(self, found.name), self.starts, self.file)
