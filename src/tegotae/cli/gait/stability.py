"""`tegotae gait stability`: multipliers of the return map of the lags, over a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import GaitCommand
from tegotae.cli.options import UNSET

if TYPE_CHECKING:
    from tegotae.analysis.gaits.stability import GaitStability as Found
    from tegotae.analysis.gaits.stability import StabilityBranch


@dataclass(frozen=True, kw_only=True)
class Stability(GaitCommand):
    """Measure how small deviations of the lags grow or decay, cycle by cycle, over a parameter."""

    over: tuple[str, float, float]
    """Parameter (omega, sigma, or one of the body), its lowest and its highest value."""
    count: int = 14
    """Number of values."""
    gaits: Annotated[tuple[str, ...], UNSET] = ()
    """Names of gaits, such as trot; by default all for this number of legs."""
    kick: float = 0.005
    """Size of the perturbation of the legs' phases, at half of the time [cycles]."""
    pairs: int = 8
    """Number of directions of the perturbation, each in both signs."""
    skip: int = 4
    """Number of cycles after the perturbation that are left out."""
    cycles: int = 8
    """Number of cycles fitted after these."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae.analysis.gaits.map import Axis
        from tegotae.analysis.gaits.simulate import write
        from tegotae.analysis.gaits.stability import stability
        from tegotae.figures.gaits.maps import stability_figure

        over = Axis.between(*self.over, self.count)
        for name, value in (("omega", self.omega), ("sigma", self.sigma)):
            if value is not None and name == over.name:
                raise TegotaeError(f"--{name} is one value, and the return map is over {name}")
        legged = self.legged()
        found = stability(
            legged,
            over,
            self.gaits or None,
            kick=self.kick,
            pairs=self.pairs,
            skip=self.skip,
            cycles=self.cycles,
            seed=self.seed,
            tolerance=self.tolerance,
        )
        document = self.document(
            legged,
            "gait stability",
            crossings=found.crossings,
            jacobians={
                branch.gait: [each.jacobian for each in branch.maps] for branch in found.branches
            },
        )
        title = self.title(legged, omega=over.name != "omega")
        written = [
            self.draw(stability_figure(found, title), "stability"),
            *write(self.folder, "stability", document, rows_of(found)),
        ]
        _print(found)
        self.wrote(written)


def rows_of(found: Found) -> dict[str, np.ndarray]:
    """The return maps as a table: a row a gait and value."""
    names = found.legged.names
    rows: dict[str, list] = {"gait": [], found.over.name: []}
    for branch in found.branches:
        for value, each, lag, stays, refused in zip(
            found.over.values, branch.maps, branch.lag, branch.stays, found.refused, strict=True
        ):
            row = {"gait": branch.gait, found.over.name: value, "largest": each.largest}
            row |= {"unexplained": each.residual, "stays": bool(stays), "refused": refused}
            row |= {f"lag_cycles_{leg}": lag[i] for i, leg in enumerate(names)}
            for number, multiplier in enumerate(each.multipliers, start=1):
                row |= {f"multiplier_{number}_real": multiplier.real}
                row |= {f"multiplier_{number}_imaginary": multiplier.imag}
            for name, x in row.items():
                rows.setdefault(name, []).append(x)
    return {name: np.array(column) for name, column in rows.items()}


def _print(found: Found) -> None:
    print_rows(
        (found.over.name, *(f"{branch.gait}: largest, unexplained" for branch in found.branches)),
        (
            (f"{value:.4g}", *(_formatted(branch, i) for branch in found.branches))
            for i, value in enumerate(found.over.values)
        ),
    )
    for each in found.crossings:
        word = "loses" if each.loses else "gains"
        print(f"{each.gait} {word} its stability at {found.over.name} {each.at:.3g}")
    values = np.array(found.over.values)[found.able]
    for branch in found.branches:
        stays = branch.stays[found.able]
        for i in np.flatnonzero(np.diff(stays.astype(int))):
            side = "stays below" if stays[i] else "stays above"
            low, high = values[i], values[i + 1]
            print(f"{branch.gait}, simulated to the end: {side} {low:.3g} … {high:.3g}")
    if not found.crossings:
        print("no multiplier crosses one between neighbouring values")


def _formatted(branch: StabilityBranch, i: int) -> str:
    each = branch.maps[i]
    return "–" if np.isnan(each.largest) else f"{each.largest:.3f}, {each.residual:.3f}"
