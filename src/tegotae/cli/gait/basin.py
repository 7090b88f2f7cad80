"""`tegotae gait basin`: which gaits come about from random phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae.cli.gait.subject import Subject
from tegotae.cli.tables import print_rows


@dataclass(frozen=True, kw_only=True)
class Basin(Subject):
    """Release a body at random phases: which gaits come about, how often, and how soon."""

    starts: int = 256
    """How many releases."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae.figures.gaits.basin import basin_figure
        from tegotae.studies.gaits.basin import find_basin
        from tegotae.studies.gaits.document import coordination_columns, write

        legged = self.legged()
        found = find_basin(legged, self.starts, seed=self.seed, tolerance=self.tolerance)
        names = legged.names
        rows = {
            "start": np.arange(self.starts),
            **{f"release_phase_rad_{leg}": found.phase_rad[i] for i, leg in enumerate(names)},
            "gait": found.gait,
            **coordination_columns(found.found, names),
        }
        document = self.document(legged, "basin", outcomes=found.outcomes)
        written = [
            self.draw(basin_figure(found, self.title(legged)), "basin"),
            *write(self.out, "basin", document, rows),
        ]
        others = [leg for leg in range(len(names)) if leg != legged.reference]
        print_rows(
            ("gait", "starts", "share", "95 %", *(f"lag {names[i]}" for i in others), "locks in"),
            (
                (
                    each.gait,
                    str(each.count),
                    f"{each.share:.3f}",
                    f"{each.low:.3f} … {each.high:.3f}",
                    *(_lag(each.lag[i], each.between[i]) for i in others),
                    "–" if np.isnan(each.lock_time_s) else f"{each.lock_time_s:.3g}",
                )
                for each in found.outcomes
            ),
        )
        print(
            f"Lags behind {names[legged.reference]} in cycles, circular mean ± deviation over the "
            f"starts; median time to lock in {legged.units[1]}."
        )
        self.wrote(written)


def _lag(mean: float, between: float) -> str:
    if np.isnan(mean):
        return "–"
    return f"{round(mean, 3) % 1.0:.3f} ± " + (f"{between:.3f}" if between < 1.0 else "all round")
