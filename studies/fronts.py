"""Fronts of the walkers: the least cost of transport over speed, family by family.

    python studies/fronts.py                                  # all of them, about half an hour
    python studies/fronts.py quadruped-c --family vanilla     # one; the others of the table stay

Interrupted work continues where it was (`--folder`). The tables are part of the package.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from kept import write_rows
from tegotae._support.files import output_folder
from tegotae._support.progress import reporting
from tegotae.studies.gaits.front import Search, search_front
from tegotae.systems.legged_systems import system
from tegotae.systems.tuned import FORCED, families

TABLES = Path(__file__).parents[1] / "src" / "tegotae" / "measures" / "fronts"
SYSTEMS = ("quadruped-c", "quadruped-a", "hexapod")
FREE = Search(coarse=8192, rounds=8, varied=1024)
TIED = Search(coarse=2048, rounds=4, varied=512, starts=2, unseen=8)
"""A forced gait has two numbers less, and its starts differ by the moment alone."""


def main() -> None:
    """Search the fronts, and write their tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("systems", nargs="*", default=SYSTEMS)
    parser.add_argument("--family", nargs="*", default=())
    parser.add_argument("--folder", type=Path, default=Path("fronts"))
    given = parser.parse_args()
    output_folder(given.folder)
    for name in given.systems:
        legged = system(name)
        for family in families(legged).values():
            if given.family and family.name not in given.family:
                continue
            search = TIED if family.name.startswith(FORCED) else FREE
            label = f"{name}-{family.name}".replace(" ", "-")
            with reporting(label, search.walkers) as reporter:
                rows = search_front(
                    legged,
                    family,
                    search,
                    kept=given.folder / f"{label}.npz",
                    progress=lambda done, of, reporter=reporter: reporter.update(done),
                )
            table = [dict(zip(rows, row, strict=True)) for row in zip(*rows.values(), strict=True)]
            write_rows(TABLES / f"{name}.csv", table, digits=6, by=("family",))


if __name__ == "__main__":
    main()
