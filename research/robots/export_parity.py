"""Trained controllers as compiled C, in closed loop with the simulated body.

    python -m research.robots.export_parity results/paper results/oscillators

takes the best run of every model in these folders of studies, writes it out as C, compiles it, and
lets it drive the hopper for 20 s at a held tick of 1 ms, beside the package's own run of the same.
A quadruped and a hexapod, vanilla, are compared by the place of their bodies. It writes
`docs/_static/export_parity.csv` and prints what the page "Deploy" says of it.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import tyro

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS.parent / "tests" / "helpers"))

from compiled import Compiled  # noqa: E402
from research.frame import main  # noqa: E402
from research.reproduction.folder import Folder  # noqa: E402
from robots import (  # noqa: E402
    HELD,
    apexes_of_the_package,
    apexes_of_the_robots,
    driven,
    is_regular,
    own_run,
)
from tegotae._support.progress import reporting  # noqa: E402
from tegotae.parts.bodies import Hopper  # noqa: E402
from tegotae.simulation.rollout import Timing  # noqa: E402
from tegotae.systems.controller_file import SavedController  # noqa: E402
from tegotae.systems.resolve import legged_system as system  # noqa: E402
from tegotae_robots.c import Export  # noqa: E402

_SETTLED_S = 12.0
_WALKERS = ("quadruped-a", "quadruped-c", "hexapod")
_WALK = Timing(duration_s=40.0, tick_s=0.008, frame_s=0.08)


@dataclass(frozen=True)
class Parity:
    """Compare, and keep the table."""

    studies: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Folders of studies."""
    out: Path = DOCS / "_static" / "export_parity.csv"
    """The table."""

    def run(self) -> None:
        """Write the table, and print its summary."""
        best = {name: saved for folder in self.studies for name, saved in trained(folder).items()}
        rows = [*hoppers(best), *(walker(name) for name in _WALKERS)]
        table = pd.DataFrame(rows)
        table.to_csv(self.out, index=False, float_format="%.6g")
        hops = table[table["regular"] & table["apexes"].gt(0)]
        print(f"{len(best)} trained controllers; {len(hops)} hop regularly, 20 s at 1 ms")
        print(f"largest gap of any of their apexes: {hops['largest_gap_mm'].max():.3f} mm")
        print(f"below 1 mm: {(hops['largest_gap_mm'] < 1.0).sum()}")
        print(table[~table["regular"]].to_string())
        print(table.tail(len(_WALKERS)).to_string())


def trained(folder: Path) -> dict[str, SavedController]:
    """Return the best run of every model of a study."""
    controllers = {}
    for record in Folder(folder).all()[0]:
        experiment = record.experiment
        weights = record.weights[int(np.nanargmax(record.best_fitness))]
        controllers[record.model] = SavedController.from_weights(
            experiment.controller, np.asarray(weights, float), experiment.omega, experiment.body
        )
    return controllers


def hoppers(best: dict[str, SavedController]) -> list[dict[str, Any]]:
    """Return one row per hopper: apexes of the compiled controllers against those of the
    package.
    """
    with tempfile.TemporaryDirectory() as folder:
        programs = []
        for i, saved in enumerate(best.values()):
            (place := Path(folder) / str(i)).mkdir()
            programs.append(Compiled(Export(saved, HELD.tick_s), place))
        results = apexes_of_the_robots(programs, Hopper(), 1.2, 0.0)
    rows = []
    with reporting("compare", len(best)) as report:
        for index, (name, of_robot) in enumerate(zip(best, results, strict=True)):
            times, heights = apexes_of_the_package(best[name])
            count = min(len(heights), len(of_robot))
            gap = np.abs(heights[:count] - of_robot[:count])
            rows.append(
                {
                    "model": name,
                    "apexes": len(heights),
                    "apexes_of_c": len(of_robot),
                    "regular": is_regular(heights[times > _SETTLED_S]),
                    "largest_gap_mm": 1e3 * gap.max(initial=0.0),
                }
            )
            report.update(index + 1, name)
    return rows


def walker(name: str) -> dict[str, Any]:
    """Return a row for a legged system: the largest distance of the two bodies at any time."""
    legs = system(name)
    saved = SavedController.from_weights(
        legs.controller, np.array(legs.weights), legs.omega, legs.body
    )
    phases = np.linspace(0.0, 5.0, legs.body.limbs)
    path = own_run(saved, _WALK, height_m=legs.system.release.height_m, phase_rad=phases[:, None])
    with tempfile.TemporaryDirectory() as folder:
        trace = driven(
            [Compiled(Export(saved, _WALK.tick_s), Path(folder))],
            legs.body,
            legs.system.release.height_m,
            phases,
            timing=_WALK,
            recorded=lambda state, contact: state.position,
        )
    every = round(_WALK.frame_s / _WALK.tick_s)
    of_robot = trace[every - 1 :: every, :, 0]
    of_package = np.stack([np.asarray(path.x_m)[:, 0], np.asarray(path.height_m)[:, 0]], axis=1)
    gap = np.abs(of_robot[:, [0, 2]] - of_package[: len(of_robot)]).max()
    row = {"model": name, "apexes": 0, "apexes_of_c": 0, "regular": True}
    return {**row, "largest_gap_mm": 1e3 * gap}


if __name__ == "__main__":
    main(Parity)
