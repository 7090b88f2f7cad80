"""Fronts of the walkers: the least cost of transport over speed, family by family.

    python -m research.gaits.fronts                               # all, in about half an hour
    python -m research.gaits.fronts quadruped-c --family vanilla  # one; other rows stay
    python -m research.gaits.fronts --show-only                        # figures and tables alone

Interrupted work continues where it was (`--folder`). The tables are part of the package.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from research.frame import Names, main, markdown_table, write_rows, write_text
from tegotae.analysis.gaits.front import Search, search_front
from tegotae.figures.gaits.maps import front_figure
from tegotae.figures.style import save_figure, styled
from tegotae.measures.fronts import front, front_table
from tegotae.systems.tuned import FORCED, front_families
from tegotae.systems.vanilla import legged_named

TABLES = Path(__file__).parents[2] / "src" / "tegotae" / "measures" / "fronts"
PAGES = Path(__file__).parents[2] / "docs" / "_static" / "gaits"
SLOW, FAST = (0.1, 0.2, 0.25, 0.3, 0.35), (0.4, 0.5, 0.7, 1.0, 1.5)
SYSTEMS = ("quadruped-c", "quadruped-a", "hexapod")
MAIN = "quadruped-c"
FREE = Search(coarse=8192, rounds=8, varied=1024)
LESS = Search(coarse=3072, rounds=6, varied=512)
"""Search for the systems other than the main one."""
TIED = Search(coarse=2048, rounds=4, varied=512, starts=2, unseen=8)
"""A forced gait has two numbers less, and its starts differ by the moment alone."""


def run(
    systems: Names = SYSTEMS,
    family: tuple[str, ...] = (),
    folder: Path = Path("fronts"),
    show_only: bool = False,
) -> None:
    """Search the fronts, and write their tables.

    Args:
        systems: names of the systems.
        family: names of the families; all by default.
        folder: of the searches.
        show_only: write the figures and tables of the kept fronts.
    """
    for name in systems:
        legged = legged_named(name)
        for searched in () if show_only else front_families(legged).values():
            if family and searched.name not in family:
                continue
            search = FREE if name == MAIN else LESS
            search = TIED if searched.name.startswith(FORCED) else search
            rows = search_front(legged, searched, search, folder / name)
            table = rows.to_dict("records")
            write_rows(TABLES / f"{name}.csv", table, digits=6, by=("family",))
        show(name)


def show(name: str) -> None:
    """Write the figure and the table of a page, of a system's kept fronts."""
    table = front_table(name)
    with styled():
        save_figure(front_figure(table, name), PAGES / f"front-{name}.png")
    families = list(dict.fromkeys(table["family"].tolist()))
    text = "\n".join(markdown(name, families, speeds) for speeds in (SLOW, FAST))
    write_text(PAGES / f"front-{name}.md", text)


def markdown(name: str, families: list[str], speeds: tuple[float, ...]) -> str:
    """Return the costs of families at some speeds, in Markdown."""
    lines = [["speed", *(f"{v:g}" for v in speeds)]]
    for family in families:
        curve = front(name, family)
        costs = [curve.cost_at(v) if curve.reaches(v) else np.nan for v in speeds]
        lines.append([family, *(f"{c:.2f}" if np.isfinite(c) else "–" for c in costs)])
    return markdown_table(lines)


if __name__ == "__main__":
    main(run)
