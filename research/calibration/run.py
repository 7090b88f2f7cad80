"""Find the bodies and readings in which vanilla controllers do what the paper says of them.

    python -m research.calibration.run measure  # all of it; 20 min of CPU time
    python -m research.calibration.run show     # tables and figures of what is measured
    python -m research.calibration.run measure --bodies 128 --fine 8 --folder results/calibration

Written are, to research/calibration, `coarse.csv` and `fine.csv` with a row per reading, as it
goes: stopped, the same command goes on. `named.csv` has the study's own reading and that of the
co-author's public program, `vanilla.csv` all V of the nearest readings. From these follow
`statements.md`, `scores.md`, `choices.md`, a picture of each, and `readings.csv`: readings that
stand for the posterior. With all tables there the command takes a few seconds, as with `--show`.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import main, markdown_table, write_rows, write_text
from research.reproduction.calibration.measure import COARSE, CalibrationGrid, measure_reading
from research.reproduction.calibration.posterior import (
    STRICTNESS,
    CalibrationPosterior,
    meeting_ratio,
    met,
    narrowed,
    posterior,
    representative,
    shortfalls,
)
from research.reproduction.calibration.prior import (
    EVALUATED,
    PRIOR,
    SECTOR_S,
    candidates,
    coordinates,
    value_at,
)
from research.reproduction.calibration.run import calibrate, read_scores
from research.reproduction.calibration.scores import SCORES, transient_score
from research.reproduction.figures.calibration import (
    posterior_figure,
    scores_figure,
    statements_figure,
)
from research.reproduction.readings.designs import cells_of
from research.reproduction.readings.experiment import experiment_under
from research.reproduction.readings.readings import AnalysisChoice, Reading
from tegotae._support import tables
from tegotae._support.files import output_folder
from tegotae.figures.style import save_figure
from tegotae.measures.evaluation import evaluate
from tegotae.systems.recipe import recipe
from tegotae.training.scoring import best_gain

FOLDER = Path(__file__).resolve().parents[2] / "research" / "calibration"

SHARES = (0.005, 0.01, 0.02)
"""Shares of all readings that are accepted: what depends on the threshold shows."""

SHARE, LEVELS = 0.02, STRICTNESS[1]
"""Share of the accepted readings and strictness that the sample is drawn from."""

NEAREST = 4
"""Readings whose V are measured as the study makes them."""

VANILLA = tuple(f"V-{name}-w{omega}" for name in ("sector", "reflex", "both") for omega in (4, 8))

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


def measure(bodies: int = 2048, fine: int = 16, folder: Path = FOLDER) -> None:
    """Measure the missing rows, and write the texts and figures.

    Args:
        bodies: number of readings of the prior.
        fine: number of the nearest readings that are measured finely.
        folder: of the tables.
    """
    output_folder(folder)
    coarse = calibrate(folder / "coarse.csv", range(bodies), COARSE)
    near = np.argsort(shortfalls(coarse, LEVELS.target), kind="stable")[:fine]
    calibrate(folder / "fine.csv", near.tolist())
    measure_named(folder / "named.csv")
    measure_vanilla(folder)
    show(folder)
    print(f"wrote tables and figures to {folder}")


def measure_named(path: Path) -> None:
    """Measure the study's own reading and the program's, unless the table is there."""
    if not path.exists():
        rows = [
            {"reading": name, **measure_reading(reading, COARSE)._asdict()}
            for name, reading in NAMED.items()
        ]
        write_rows(path, rows, digits=4)


def measure_vanilla(folder: Path) -> None:
    """Measure all six V of the nearest readings with the study's own search, where it is to do."""
    path = folder / "vanilla.csv"
    if path.exists():
        return
    measured = read(folder)
    far = np.nan_to_num(measured.distance_finely, nan=math.inf)
    rows = []
    for body in measured.bodies[np.argsort(far, kind="stable")[:NEAREST]].tolist():
        reading = candidates(body + 1)[body]
        for name in VANILLA:
            protocol = CalibrationGrid().protocol
            experiment = experiment_under(reading, recipe(name), protocol=protocol)
            gain, _ = best_gain(experiment)
            metrics = ("limit_cycle_share", "t0_s", "t1_s")
            controller, omega = experiment.controller, experiment.omega
            results = evaluate(
                controller, [[gain]], omega, experiment.body, protocol, metrics=metrics
            ).episodes
            settles, t0_s, t1_s = (results[key][0] for key in metrics)
            labels = {"body": body, "model": name, "sigma_m_g": gain * reading.hopper.weight_n}
            scores = {
                "settled": settles.sum(),
                "short_t0": transient_score(t0_s, protocol.undisturbed_s),
                "short_t1": transient_score(t1_s, protocol.disturbed_s),
            }
            rows.append(labels | scores)
    write_rows(path, rows, digits=4)


@dataclasses.dataclass(frozen=True)
class CalibrationTables:
    """Content of the tables, all arrays in the order of the readings' numbers.

    Args:
        bodies: numbers of the readings in the prior, [readings].
        scores: by the coarse maps, [readings, scores]. The posterior is of these, in which chance
            is the same for all.
        fine: by the fine maps, [readings, scores]; NaN where there are none.
        places: where the readings lie, [readings, choices].
        named: scores of the named readings, [named, scores].
    """

    bodies: np.ndarray
    scores: np.ndarray
    fine: np.ndarray
    places: np.ndarray
    named: np.ndarray

    @property
    def distance_finely(self) -> np.ndarray:
        """Shortfall by the fine maps; NaN where there are none."""
        finely = shortfalls(self.fine, LEVELS.target)
        return np.where(np.isfinite(self.fine).any(axis=1), finely, math.nan)

    @cached_property
    def posterior(self) -> CalibrationPosterior:
        """The posterior of the middle level."""
        return found_by(self.scores)[LEVELS.name]


def read(folder: Path) -> CalibrationTables:
    """Read the tables of a folder."""
    coarse, fine = read_scores(folder / "coarse.csv"), read_scores(folder / "fine.csv")
    bodies = sorted(coarse)
    readings = candidates(bodies[-1] + 1)
    return CalibrationTables(
        np.array(bodies),
        np.array([coarse[body] for body in bodies]),
        np.array([fine.get(body, [math.nan] * len(SCORES)) for body in bodies]),
        np.array([coordinates(readings[body]) for body in bodies]),
        pd.read_csv(folder / "named.csv")[list(SCORES)].to_numpy(),
    )


def found_by(scores: np.ndarray, share: float = SHARE) -> dict[str, CalibrationPosterior]:
    """Return the posterior of each strictness."""
    return {
        strictness.name: posterior(shortfalls(scores, strictness.target), share)
        for strictness in STRICTNESS
    }


def show(folder: Path) -> None:
    """Write the results of the tables."""
    measured = read(folder)
    posteriors, scores = found_by(measured.scores), measured.scores
    write_text(folder / "statements.md", statements(measured))
    write_text(folder / "scores.md", scores_table(measured))
    write_text(folder / "choices.md", choices(measured))
    sample = measured.bodies[representative(posteriors[LEVELS.name], measured.places, SAMPLE)]
    readings = candidates(int(sample.max()) + 1)
    rows = [cells_of(readings[body]) for body in sample]
    columns = {choice.name: [row[i] for row in rows] for i, choice in enumerate(PRIOR)}
    tables.write_csv(folder / "readings.csv", {"body": sample.tolist(), **columns})
    figure = posterior_figure(measured.places, posteriors, NAMED["study"], NAMED["program"])
    save_figure(figure, folder / "posterior.png")
    shares = {level.name: met(scores, level.target).mean(axis=0) for level in STRICTNESS}
    words = [WORDS[name] for name in SCORES]
    figure = statements_figure(words, shares, meeting_ratio(scores, LEVELS.target))
    save_figure(figure, folder / "statements.png")
    ends = (0.05, 0.5, 0.95)
    accepted = np.array([[_inside(measured, x, q) for x in scores.T] for q in ends])
    figure = scores_figure(
        words,
        {"all readings": np.quantile(scores, ends, axis=0), "posterior": accepted},
        dict(zip(NAMED, measured.named, strict=True)),
        {f"met, {level.name}": level.target for level in STRICTNESS},
    )
    save_figure(figure, folder / "scores.png")


def statements(measured: CalibrationTables) -> str:
    """Tabulate for each statement the readings that meet it, and the score from which on it is
    met."""
    counts = {level.name: met(measured.scores, level.target) for level in STRICTNESS}
    rows = [["statement", *(f"meet it, {name}" for name in counts)]]
    for i, name in enumerate(SCORES):
        shares = [
            f"{counts[level.name][:, i].mean():.0%} (≥ {level.target[i]:.2g})"
            for level in STRICTNESS
        ]
        rows.append([WORDS[name], *shares])
    maxima = [f"{matches.sum(axis=1).max()} of {len(SCORES)}" for matches in counts.values()]
    return markdown_table([*rows, ["most that one reading meets", *maxima]])


def scores_table(measured: CalibrationTables) -> str:
    """Tabulate for each statement the median score among all and the accepted readings, and the
    scores of the named ones."""
    rows = [["statement", "all", "posterior", "finely", *NAMED]]
    distance = measured.posterior.distance
    named = shortfalls(measured.named, LEVELS.target)
    columns = zip(SCORES, measured.scores.T, measured.fine.T, measured.named.T, strict=True)
    lines = [(WORDS[name], *values) for name, *values in columns]
    lines.append((f"shortfall, {LEVELS.name}", distance, measured.distance_finely, named))
    for label, scores, fine, of_named in lines:
        cells = [np.median(scores), *(_inside(measured, x) for x in (scores, fine)), *of_named]
        rows.append([label, *(f"{value:.2f}" for value in cells)])
    return markdown_table(rows)


def choices(measured: CalibrationTables) -> str:
    """Tabulate for each choice the middle and the 90 % range of the posterior, and how narrow it
    is."""
    scores, places, posterior = measured.scores, measured.places, measured.posterior
    criteria = [(LEVELS.name, share) for share in SHARES]
    criteria += [(level.name, SHARE) for level in STRICTNESS if level is not LEVELS]
    rows = [["choice", "prior", "posterior", *(f"{name}, {share:.1%}" for name, share in criteria)]]
    narrow = [narrowed(places, found_by(scores, share)[name]) for name, share in criteria]
    for i, choice in enumerate(PRIOR):
        position, labels = places[:, i], [_label(choice, value) for value in choice.values]
        if choice.levels:
            masks = (
                np.isclose(position[posterior.accepted], choice.place(v)) for v in choice.values
            )
            inside = " / ".join(f"{posterior.weights[mask].sum():.0%}" for mask in masks)
        else:
            values = (_inside(measured, position, q) for q in (0.5, 0.05, 0.95))
            texts = [_label(choice, value_at(choice, x)) for x in values]
            inside = f"{texts[0]} ({texts[1]} … {texts[2]})"
        prior = (" / " if choice.levels else " … ").join(labels)
        rows.append([choice.label, prior, inside, *(f"{widths[i]:.2f}" for widths in narrow)])
    return markdown_table(rows)


def _label(choice: AnalysisChoice, value: object) -> str:
    if value is None:
        return "in phase"
    if choice.name == "flight_damping":
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return "ω_t" if value == (0.0,) else "five ω"
    if choice.name == "sector_start":
        return f"{float(value) / math.pi:.2f}π"  # type: ignore[arg-type]
    return f"{value:.2g}" if isinstance(value, float) else str(value)


def _inside(measured: CalibrationTables, values: np.ndarray, share: float = 0.5) -> float:
    """Return a quantile of the known values in the posterior."""
    posterior = measured.posterior
    values, weights = values[posterior.accepted], posterior.weights
    values, weights = values[~np.isnan(values)], weights[~np.isnan(values)]
    order = np.argsort(values)
    reached = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][min(int(np.searchsorted(reached, share)), len(values) - 1)])


if __name__ == "__main__":
    main(measure, show)
