"""Compare the kept optimum with results of more effort: finer forces, other starts.

    python -m research.experiments.finer_optimum

solves rows of the kept table again with 160 intervals of constant force a swing instead of 40, and
writes `optimum.finer.csv` and `optimum.finer.md` to `docs/_static/figures`, in about two minutes of
a core (extra `optimum`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from research.frame import write_rows, write_text
from research.reproduction.optimum import optimise
from tegotae._support.tables import read_csv
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper

KEPT = Path(__file__).parents[2] / "docs" / "_static" / "figures"
OMEGAS = (3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0, 9.0, 10.0)
"""Frequencies of the table at which it is asked [rad/s]."""
INTERVALS = 160
STARTS = 3


def main() -> None:
    """Find and write."""
    rows = []
    for omega in OMEGAS:
        reference = float(curve().interpolate("cot_inverse", omega))
        finer = optimise(Hopper(), omega, starts=STARTS, intervals=INTERVALS, seed=1).cot_inverse
        rows.append({"omega": omega, "kept": reference, "finer": finer, "ratio": finer / reference})
        print(rows[-1], flush=True)
    write_rows(KEPT / "optimum.finer.csv", rows, digits=6)
    write_text(KEPT / "optimum.finer.md", text())


def text() -> str:
    """Return the page's table, from the kept one."""
    table = read_csv(KEPT / "optimum.finer.csv")
    ratio = np.array(table["ratio"], float)
    lines = ["| ω [rad/s] | finer over kept |", "|---|---|"]
    lines += [f"| {omega} | {x:.4f} |" for omega, x in zip(table["omega"], ratio, strict=True)]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
