"""Compute the limits of bodies under the disturbances that controllers are tested with.

    python -m research.generalisation.physical_limit

For every level of `tegotae robustness` that makes another hopper, and both frequencies of the
models: the largest CoT⁻¹ of period 1 that was found under any force, and the proved bound. Written
to `possible.csv` and `possible.md` in `research/generalisation`, in about nine minutes of a
core (extra `optimum`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from research.frame import main, markdown_table, write_rows, write_text
from research.reproduction.optimum import optimise, upper_bound
from research.reproduction.optimum.problem import most_lift_off
from tegotae._support.errors import TegotaeError
from tegotae._support.tables import read_csv
from tegotae.analysis.generalisation.disturbances import CATALOGUE
from tegotae.parts.bodies import Hopper

KEPT = Path(__file__).parents[2] / "research" / "generalisation"
FIELDS = {
    "mass": "mass_kg",
    "stiffness": "stiffness_n_per_m",
    "damping": "damping_ns_per_m",
    "gravity": "gravity_m_per_s2",
    "leg-length": "rest_length_m",
    "strength": "max_force_n",
}
"""Conditions that make another hopper, and the number that they scale."""
OMEGAS = (4.0, 8.0)
"""Frequencies of the models [rad/s]."""
STARTS = 3
FREE = 1000.0
"""Efficiency above which no work is done, but for the optimiser's tolerance [m/J]."""


def cases() -> Iterator[tuple[str, float, float]]:
    """Yield condition, level and trained frequency [rad/s]."""
    for name in ("omega", *FIELDS):
        disturbance = CATALOGUE[name]
        for level in sorted({disturbance.neutral, *disturbance.levels}):
            yield from ((name, level, omega) for omega in OMEGAS)


def disturbed(name: str, level: float) -> Hopper:
    """Return the hopper under a condition."""
    body = Hopper()
    if name == "omega":
        return body
    return dataclasses.replace(body, **{FIELDS[name]: level * getattr(body, FIELDS[name])})


def row(name: str, level: float, omega: float) -> dict[str, Any]:
    """Return the best gait found and the proved bound."""
    body = disturbed(name, level)
    frequency = omega * level if name == "omega" else omega
    row = {"condition": name, "level": level, "omega": omega}
    try:
        best = optimise(body, frequency, starts=STARTS).cot_inverse
    except TegotaeError:
        best = np.nan
    try:
        bound = upper_bound(body, frequency, best=float(np.nan_to_num(best)))
    except TegotaeError:
        bound = np.nan
    # What it falls from, if full force stops it within the leg: at least this, as the
    # damper helps.
    caught = most_lift_off(body) ** 2 / (2.0 * body.gravity_m_per_s2 * body.rest_length_m)
    return {**row, "cot_inverse": best, "upper_bound": bound, "caught_l0": caught}


def text() -> str:
    """Return the table of the page, from the kept one."""
    table = read_csv(KEPT / "possible.csv")
    rows = [dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True)]
    titles = ["condition", "level"]
    titles += [f"found, bound at {omega:g} rad/s [m/J]" for omega in OMEGAS]
    lines = []
    for name, level in dict.fromkeys((r["condition"], r["level"]) for r in rows):
        mine = [r for r in rows if (r["condition"], r["level"]) == (name, level)]
        cells = [f"{_text(r['cot_inverse'])}, {_text(r['upper_bound'])}" for r in mine]
        caught = f"{float(mine[0]['caught_l0']):.1f}"
        lines.append([name, level, *cells, caught])
    return markdown_table([[*titles, "falls that it can stop [l0]"], *lines])


def _text(cell: str) -> str:
    if not cell:
        return "–"
    return f"{float(cell):.2f}" if float(cell) < FREE else "∞"


def run() -> None:
    """Search the best gaits and the bounds, and write the tables."""
    rows = []
    for case in cases():
        rows.append(row(*case))
        print(rows[-1], flush=True)
    write_rows(KEPT / "possible.csv", rows, digits=4)
    write_text(KEPT / "possible.md", text())


if __name__ == "__main__":
    main(run)
