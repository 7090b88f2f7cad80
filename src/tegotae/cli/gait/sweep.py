"""`tegotae gait sweep`: the frequency up and down a staircase."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_POINTS, MOST_RAD_PER_S
from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import GaitCommand
from tegotae.cli.options import UNSET

if TYPE_CHECKING:
    from tegotae.analysis.gaits.sweep import Hysteresis


@dataclass(frozen=True, kw_only=True)
class Sweep(GaitCommand):
    """Raise the frequency step by step and lower it again, to find gait changes and hysteresis."""

    levels: tuple[float, float]
    """Lowest and highest frequency ω [rad/s]."""
    count: int = 16
    """Number of levels."""
    dwell: Annotated[float | None, UNSET] = None
    """Duration of each level [s]; by default half of the system's duration."""
    starts: int = 16
    """Number of releases in each direction."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae.analysis.gaits.simulate import coordination_columns, write
        from tegotae.analysis.gaits.sweep import sweep
        from tegotae.figures.gaits.lags import sweep_figure

        omega = self._omega()
        legged = self.legged()
        dwell = 0.5 * legged.timing.duration_s if self.dwell is None else self.dwell
        found = sweep(
            legged,
            omega,
            dwell_s=dwell,
            starts=self.starts,
            seed=self.seed,
            tolerance=self.tolerance,
        )
        tables = []
        for way, each in found.found.items():
            level, start = np.meshgrid(omega, np.arange(self.starts), indexing="ij")
            together = (np.moveaxis(np.asarray(x), 0, -2) for x in each)
            flat = type(each)(*(x.reshape(*x.shape[:-2], -1) for x in together))
            tables.append(
                {
                    "direction": np.full(level.size, way),
                    "omega_rad_per_s": level.ravel(),
                    "start": start.ravel(),
                    "gait": found.gait[way].ravel(),
                    **coordination_columns(flat, legged.names),
                }
            )
        rows = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
        document = self.document(
            legged,
            "gait sweep",
            dwell_s=dwell,
            hysteresis=found.hysteresis,
            bistable=found.bistable,
        )
        written = [
            self.draw(sweep_figure(found, self.title(legged, omega=False)), "sweep"),
            *write(self.folder, "sweep", document, rows),
        ]
        print_rows(
            ("ω", "gaits on the way up", "gaits on the way down"),
            (
                (f"{w:.4g}", _listed(found.gait["up"][i]), _listed(found.gait["down"][i]))
                for i, w in enumerate(omega)
            ),
        )
        for each in found.hysteresis:
            print(formatted(each))
        if not found.hysteresis:
            print("no named gait changes on the way up and returns on the way down")
        where = ", ".join(f"{w:.4g}" for w in found.bistable)
        print(f"lags differ between the two ways at {where or 'no level'}")
        self.wrote(written)

    def _omega(self) -> np.ndarray:
        low, high = self.levels
        require_count("count", self.count, least=2, most=MOST_POINTS)
        require_finite("the lowest level", low, above=0.0, most=MOST_RAD_PER_S)
        require_finite("the highest level", high, above=0.0, most=MOST_RAD_PER_S)
        if self.omega is not None:
            raise TegotaeError("--omega is one frequency, and a sweep has its --levels")
        if self.duration is not None and self.dwell is not None:
            raise TegotaeError("--duration does nothing beside --dwell; leave one of them out")
        if not low < high:
            raise TegotaeError(
                f"levels go from {low:g} to {high:g}; the second must be greater than the first"
            )
        return np.linspace(low, high, self.count)


def formatted(change: Hysteresis) -> str:
    """A change of gait and its hysteresis in one line."""
    up, down, width = map(_between, (change.up, change.down, change.width))
    return (
        f"{change.slow} to {change.fast}: up between {up} ({change.starts_up} starts), down "
        f"between {down} ({change.starts_down}); hysteresis between {width}"
    )


def _between(ends: tuple[float, float]) -> str:
    low, high = (round(end, 9) for end in ends)  # levels differ from one another to rounding
    return f"{low:.3g} and {high:.3g}"


def _listed(names: np.ndarray) -> str:
    """Names with how often each is there, the most common first."""
    found, counts = np.unique(names, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return ", ".join(f"{found[i]} {counts[i]}" for i in order)
