"""Which bodies and readings make the vanilla controllers do what the paper says of them.

    python studies/calibration.py --bodies 2000 --out results/calibration
    python studies/calibration.py --bodies 64 --coarse --out results/calibration-coarse

Writes scores.csv, a row per reading, as it goes: stopped, the same command goes on. Then
posterior.md: the readings that agree best at several thresholds, and how much narrower each choice
is among them than in the prior; and where the co-author's public program lies.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tegotae._support.files import output_folder, write_atomically
from tegotae.figures.report.markdown import table
from tegotae.simulation.rollout import Timing
from tegotae.studies.paper.calibration.measure import CalibrationGrid, measure
from tegotae.studies.paper.calibration.posterior import distances, narrowed, posterior
from tegotae.studies.paper.calibration.prior import PRIOR, SECTOR_S, candidates, coordinates
from tegotae.studies.paper.calibration.run import calibrate
from tegotae.studies.paper.calibration.scores import SCORES
from tegotae.studies.paper.multiverse.readings import Reading

SHARES = (0.02, 0.05, 0.1)
"""Shares of the readings that are accepted: what depends on the threshold shows."""

PROGRAM = Reading(release=1.0, flight_damping=1.0, sector_start=1.6 * math.pi, sector_s=SECTOR_S)
"""The reading of the co-author's public program."""

COARSE = CalibrationGrid(
    gains=tuple(np.linspace(0.1, 12.0, 16).tolist()),
    omegas=tuple(np.linspace(2.0, 10.0, 17).tolist()),
    timing=Timing(duration_s=24.0, tick_s=0.002),
)


def main(words: Sequence[str] | None = None) -> None:
    """Measure what is missing, and write what follows from it."""
    parser = argparse.ArgumentParser(description="Calibrate readings on V and Fig. 4.")
    parser.add_argument("--bodies", type=int, default=2000)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--coarse", action="store_true", help="a sixth of the map's points")
    given = parser.parse_args(words)
    grid = COARSE if given.coarse else CalibrationGrid()
    output_folder(given.out)
    scores = calibrate(given.out / "scores.csv", given.bodies, grid)
    program = np.array(measure(PROGRAM, grid))
    write_atomically(given.out / "posterior.md", tables_of(scores, program, given.bodies))
    print(f"wrote scores.csv and posterior.md to {given.out}")


def tables_of(scores: np.ndarray, program: np.ndarray, count: int) -> str:
    """The tables of the page."""
    places = np.array([coordinates(reading) for reading in candidates(count)])
    shares = [share for share in SHARES if round(share * count) >= 1]
    found = [posterior(scores, share) for share in shares]
    heads = [f"nearest {share:.0%}" for share in shares]
    rows = [["statement", "all", *heads, "co-author's program"]]
    for i, name in enumerate(SCORES):
        values = [scores[:, i], *(scores[each.accepted, i] for each in found)]
        rows.append([name, *(_median(each) for each in values), f"{program[i]:.2f}"])
    far = distances(scores)
    own = float(distances(program[None])[0])
    thresholds = (f"{each.threshold:.2f}" for each in found)
    rows.append(["distance", f"{np.median(far):.2f}", *thresholds, f"{own:.2f}"])
    narrow = [["choice", *heads]]
    for choice, *spread in zip(
        PRIOR, *(narrowed(places, each.accepted) for each in found), strict=True
    ):
        narrow.append([choice.label, *(f"{value:.2f}" for value in spread)])
    return table(rows) + "\n" + table(narrow)


def _median(values: np.ndarray) -> str:
    known = values[np.isfinite(values)]
    return f"{np.median(known):.2f}" if len(known) else "–"


if __name__ == "__main__":
    main()
