"""`tegotae gait map`: the gait and its cost over two parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.progress import reporting
from tegotae._support.workplace import GAIT_MAP, require_free_for
from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import GaitCommand

if TYPE_CHECKING:
    from tegotae.analysis.gaits import Legged
    from tegotae.analysis.gaits.map import Axis, GaitMap


@dataclass(frozen=True, kw_only=True)
class Map(GaitCommand):
    """Map the gaits over two parameters: omega, sigma, or parameters of the body."""

    x: tuple[str, float, float]
    """Columns: a parameter, its lowest and its highest value, such as com_x_m -0.3 0.3. For a
    parameter with one value per leg, such as hips_x_m, they are factors on all values."""
    y: tuple[str, float, float]
    """Rows: another parameter, its lowest and its highest value."""
    cells: tuple[int, int] = (60, 60)
    """Numbers of columns and rows."""
    starts: int = 4
    """Number of releases per cell."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae.analysis.gaits.map import Axis, gait_map
        from tegotae.analysis.gaits.simulate import write
        from tegotae.figures.gaits.maps import map_figure

        require_free_for(self.folder, GAIT_MAP)
        x = Axis.between(*self.x, self.cells[0])
        y = Axis.between(*self.y, self.cells[1])
        legged = self._legged(x, y)
        with reporting("cells", x_times_y(x, y)) as reporter:
            found = gait_map(
                legged,
                x,
                y,
                starts=self.starts,
                seed=self.seed,
                tolerance=self.tolerance,
                kept=self.folder / "map.partial.npz",
                progress=lambda done, of: reporter.update(done + x_times_y(x, y) - of),
            )
        given = {axis.name for axis in (x, y)}
        document = self.document(legged, "gait map", x=x, y=y)
        written = [
            self.draw(map_figure(found, self.title(legged, omega="omega" not in given)), "map"),
            *write(self.folder, "map", document, rows_of(found)),
        ]
        _print(found)
        self.wrote(written)

    def _legged(self, x: Axis, y: Axis) -> Legged:
        for name, value in (("omega", self.omega), ("sigma", self.sigma)):
            if value is not None and name in (x.name, y.name):
                raise TegotaeError(f"--{name} is one value, and the map is over {name}")
        require_finite("tolerance", self.tolerance, above=0.0, most=0.5)
        return self.legged()


def x_times_y(x: Axis, y: Axis) -> int:
    """How many cells a map has."""
    return len(x.values) * len(y.values)


def rows_of(found: GaitMap) -> dict[str, np.ndarray]:
    """A map as a table: a row a cell, with what most of its starts do."""
    cells, names = found.cells, found.legged.names
    x, y = np.meshgrid(found.x.values, found.y.values)
    columns = {
        found.x.name: x,
        found.y.name: y,
        "gait": cells.gait,
        "share": cells.share,
        "fallen_share": cells.fallen,
        **{f"lag_cycles_{leg}": cells.lag[..., i] for i, leg in enumerate(names)},
        "lock_time_s": cells.lock_time_s,
        "speed_m_per_s": cells.speed_m_per_s,
        "cost_of_transport": cells.cost_of_transport,
        "refused": found.refused,
    }
    return {name: values.ravel() for name, values in columns.items()}


def _print(found: GaitMap) -> None:
    cells = found.cells
    listed, counts = np.unique(cells.gait, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    print_rows(
        ("gait of most starts", "cells", "share", "all starts agree", "cost of transport"),
        (
            (
                str(listed[i]),
                str(counts[i]),
                f"{counts[i] / cells.gait.size:.3f}",
                f"{np.mean(cells.share[cells.gait == listed[i]] == 1.0):.3f}",
                _range(cells.cost_of_transport[cells.gait == listed[i]]),
            )
            for i in order
        ),
    )


def _range(values: np.ndarray) -> str:
    values = values[np.isfinite(values)]
    return f"{values.min():.3g} … {values.max():.3g}" if values.size else "–"
