"""Which bodies and readings make the vanilla controllers do what the paper says of them.

    python studies/calibration.py                   # all of it; 40 min of CPU time
    python studies/calibration.py --bodies 128 --fine 16 --random 4 --folder results/calibration

Written are, to docs/_static/calibration, `coarse.csv` and `fine.csv` with a row per reading, as it
goes: stopped, the same command goes on. `named.csv` has the study's own reading and that of the
co-author's public program. From these follow `statements.md`, `choices.md`, `posterior.png`,
`statements.png`, and `readings.csv`: readings that stand for the posterior. With all tables there,
the command takes a few seconds.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.files import output_folder, write_atomically
from tegotae.figures.calibration import posterior_figure, statements_figure
from tegotae.figures.report.markdown import table
from tegotae.figures.style import save_figure
from tegotae.studies.paper.calibration.measure import COARSE, measure
from tegotae.studies.paper.calibration.posterior import (
    STRICTNESS,
    CalibrationPosterior,
    distances,
    met,
    narrowed,
    posterior,
    representative,
    shortfalls,
    together,
)
from tegotae.studies.paper.calibration.prior import (
    EVALUATED,
    PRIOR,
    SECTOR_S,
    candidates,
    coordinates,
    value_at,
)
from tegotae.studies.paper.calibration.run import calibrate, read_scores
from tegotae.studies.paper.calibration.scores import SCORES
from tegotae.studies.paper.multiverse.designs import cells_of
from tegotae.studies.paper.multiverse.readings import AnalysisChoice, Reading

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "_static" / "calibration"

SHARES = (0.01, 0.02, 0.05)
"""Shares of all readings that are accepted: what depends on the threshold shows."""

SHARE, LEVELS = 0.02, STRICTNESS[1]
"""Those that the sample is of."""

SAMPLE = 24
"""Readings that stand for the posterior."""

_PROGRAM = Reading(release=1.0, flight_damping=1.0, sector_start=1.6 * math.pi, sector_s=SECTOR_S)

NAMED = {
    "study": Reading(),
    "study, robust σ": Reading(tuned_over=EVALUATED),
    "program": _PROGRAM,
    "program, robust σ": dataclasses.replace(_PROGRAM, tuned_over=EVALUATED),
}
"""The study's own reading, and that of the co-author's public program, which says no fitness."""

WORDS = {
    "settles": "settles at every ω",
    "short_t0": "short T0",
    "short_t1": "short T1",
    "dependent": "CPGu high",
    "slows": "slows while it pushes",
    "sector_line": "sector: best σ on a line",
    "reflex_stays": "reflex: resonance stays",
    "quick_loss": "quick loss at fixed σ",
}


def main(words: Sequence[str] | None = None) -> None:
    """Measure what is missing, and write what follows from it."""
    parser = argparse.ArgumentParser(description="Calibrate readings on V and Fig. 4.")
    parser.add_argument("--bodies", type=int, default=2048, help="readings of the prior")
    parser.add_argument("--fine", type=int, default=200, help="of these, the nearest, finely")
    parser.add_argument("--random", type=int, default=50, help="and the first of the prior, finely")
    parser.add_argument("--folder", type=Path, default=FOLDER)
    given = parser.parse_args(words)
    folder = given.folder
    output_folder(folder)
    coarse = calibrate(folder / "coarse.csv", range(given.bodies), COARSE)
    calibrate(folder / "fine.csv", worth_a_look(coarse, given.fine, given.random))
    if not (folder / "named.csv").exists():
        scores = [measure(reading) for reading in NAMED.values()]
        columns = {name: [getattr(each, name) for each in scores] for name in SCORES}
        tables.write_csv(folder / "named.csv", {"reading": list(NAMED), **columns}, digits=4)
    show(folder)
    print(f"wrote tables and figures to {folder}")


def worth_a_look(scores: np.ndarray, nearest: int, random: int) -> list[int]:
    """Numbers of readings: the nearest by any measure of distance, and the first of the prior.

    The latter are as good as drawn at random, and show how far coarse scores are from fine ones.
    """
    measures = [distances(scores), *(shortfalls(scores, each.target) for each in STRICTNESS)]
    ranks = np.min([np.argsort(np.argsort(each, kind="stable")) for each in measures], axis=0)
    best = np.argsort(ranks, kind="stable")[:nearest]
    return sorted({*best.tolist(), *range(min(random, len(scores)))})


def read(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coarse scores, fine scores (NaN where there are none), and where all readings lie."""
    rows = read_scores(folder / "coarse.csv")
    coarse = np.array([rows[body] for body in range(len(rows))])
    fine = np.full_like(coarse, np.nan)
    for body, scores in read_scores(folder / "fine.csv").items():
        fine[body] = scores
    return coarse, fine, np.array([coordinates(each) for each in candidates(len(rows))])


def found_by(fine: np.ndarray, share: float = SHARE) -> dict[str, CalibrationPosterior]:
    """The posterior by each strictness; readings without a fine look are as far as can be."""
    looked = np.isfinite(fine).any(axis=1)
    return {
        each.name: posterior(np.where(looked, shortfalls(fine, each.target), 1.0), share)
        for each in STRICTNESS
    }


def show(folder: Path) -> None:
    """Write what follows from the tables."""
    coarse, fine, places = read(folder)
    found = found_by(fine)
    write_atomically(folder / "statements.md", statements(folder))
    write_atomically(folder / "choices.md", choices(folder))
    sample = representative(found[LEVELS.name], places, SAMPLE)
    readings = candidates(len(places))
    rows = [cells_of(readings[body], PRIOR) for body in sample]
    columns = {choice.name: [row[i] for row in rows] for i, choice in enumerate(PRIOR)}
    tables.write_csv(folder / "readings.csv", {"body": sample.tolist(), **columns})
    figure = posterior_figure(places, found, NAMED["study"], NAMED["program"])
    save_figure(figure, folder / "posterior.png")
    shares = {each.name: met(coarse, each.target).mean(axis=0) for each in STRICTNESS}
    words = [WORDS[name] for name in SCORES]
    figure = statements_figure(words, shares, together(coarse, LEVELS.target))
    save_figure(figure, folder / "statements.png")


def statements(folder: Path) -> str:
    """Per statement: how many meet it, its score among all and the accepted, and of those named."""
    coarse, fine, _ = read(folder)
    own = found_by(fine)[LEVELS.name]
    named = tables.read_csv(folder / "named.csv")
    counts = [met(coarse, each.target) for each in STRICTNESS]
    levels = [f"{each.name}" for each in STRICTNESS]
    rows = [["statement", *levels, "median of all", "of the posterior", *NAMED]]
    for i, name in enumerate(SCORES):
        shares = [f"{each[:, i].mean():.0%} (≥ {s.target[i]:.2g})" for each, s in _with(counts)]
        inside = _quantile(fine[own.accepted, i], own.weights, 0.5)
        cells = [f"{float(cell):.2f}" for cell in named[name]]
        rows.append([WORDS[name], *shares, f"{np.median(coarse[:, i]):.2f}", f"{inside:.2f}"])
        rows[-1] += cells
    most = [each.sum(axis=1).max() for each in counts]
    rows.append(["most met by one reading", *(f"{n} of {len(SCORES)}" for n in most)])
    rows[-1] += [""] * (2 + len(NAMED))
    scores = np.array([[float(named[name][k]) for name in SCORES] for k in range(len(NAMED))])
    far = shortfalls(scores, LEVELS.target)
    all_far = shortfalls(coarse, LEVELS.target)
    inside = _quantile(own.distance[own.accepted], own.weights, 0.5)
    rows.append(["shortfall (middle)", "", "", "", f"{np.median(all_far):.2f}", f"{inside:.2f}"])
    rows[-1] += [f"{value:.2f}" for value in far]
    return table(rows)


def _with(counts: list[np.ndarray]) -> list[tuple]:
    return list(zip(counts, STRICTNESS, strict=True))


def choices(folder: Path) -> str:
    """Per choice: the posterior's middle and its 90 % range, and how narrow it is."""
    _, fine, places = read(folder)
    own = found_by(fine)[LEVELS.name]
    heads = [f"{each.name}, {share:.0%}" for share in SHARES for each in STRICTNESS]
    rows = [["choice", "prior", "posterior", *heads]]
    narrow = [narrowed(places, each) for share in SHARES for each in found_by(fine, share).values()]
    for i, choice in enumerate(PRIOR):
        at = places[own.accepted, i]
        if choice.levels:
            weights = [own.weights[np.isclose(at, choice.place(v))].sum() for v in choice.values]
            named = [_named(choice, value) for value in choice.values]
            prior = " / ".join(named)
            inside = " / ".join(f"{weight:.0%}" for weight in weights)
        else:
            prior = " … ".join(_named(choice, value) for value in choice.values)
            low, middle, high = (_quantile(at, own.weights, q) for q in (0.05, 0.5, 0.95))
            shown = [_named(choice, value_at(choice, float(x))) for x in (middle, low, high)]
            inside = f"{shown[0]} ({shown[1]} … {shown[2]})"
        rows.append([choice.label, prior, inside, *(f"{each[i]:.2f}" for each in narrow)])
    return table(rows)


def _named(choice: AnalysisChoice, value: object) -> str:
    if value is None:
        return "in phase"
    if isinstance(value, tuple):
        return "ω_t" if value == (0.0,) else "five ω"
    if choice.name == "sector_start":
        return f"{float(value) / math.pi:.2f}π"  # type: ignore[arg-type]
    return f"{value:.2g}" if isinstance(value, float) else str(value)


def _quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """A weighted quantile."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order][min(int(np.searchsorted(reached, share)), len(values) - 1)])


if __name__ == "__main__":
    main()
