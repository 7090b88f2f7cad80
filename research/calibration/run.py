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
from pathlib import Path

import numpy as np

from research.frame import main, markdown_table
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
from tegotae._support.files import output_folder, write_atomically
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
        scores = [measure_reading(reading, COARSE) for reading in NAMED.values()]
        columns = {name: [getattr(result, name) for result in scores] for name in SCORES}
        tables.write_csv(path, {"reading": list(NAMED), **columns}, digits=4)


def measure_vanilla(folder: Path) -> None:
    """Measure all six V of the nearest readings with the study's own search, where it is to do."""
    path = folder / "vanilla.csv"
    if path.exists():
        return
    measured = read(folder)
    far = np.where(
        np.isfinite(measured.fine).any(axis=1), shortfalls(measured.fine, LEVELS.target), math.inf
    )
    rows = []
    for body in measured.bodies[np.argsort(far, kind="stable")[:NEAREST]].tolist():
        reading = candidates(body + 1)[body]
        for name in VANILLA:
            experiment = experiment_under(
                reading, recipe(name), protocol=CalibrationGrid().protocol
            )
            gain, _ = best_gain(experiment)
            results = evaluate(
                experiment.controller,
                [[gain]],
                experiment.omega,
                experiment.body,
                experiment.protocol,
                metrics=("limit_cycle_share", "t0_s", "t1_s"),
            ).episodes
            settles, t0_s, t1_s = (results[key][0] for key in ("limit_cycle_share", "t0_s", "t1_s"))
            rows.append((body, name, gain * reading.hopper.weight_n, settles.sum()))
            rows[-1] += (transient_score(t0_s, experiment.protocol.undisturbed_s),)
            rows[-1] += (transient_score(t1_s, experiment.protocol.disturbed_s),)
    head = ("body", "model", "sigma_m_g", "settled", "short_t0", "short_t1")
    columns = {name: [row[i] for row in rows] for i, name in enumerate(head)}
    tables.write_csv(path, columns, digits=4)


@dataclasses.dataclass(frozen=True)
class CalibrationTables:
    """Content of the tables, all arrays in the order of the readings' numbers.

    Args:
        bodies: numbers of the readings in the prior, [readings].
        scores: by the coarse maps, [readings, scores]. The posterior is of these, in which chance
            is the same for all.
        fine: by the fine maps, [readings, scores]; NaN where there are none.
        places: where the readings lie, [readings, choices].
    """

    bodies: np.ndarray
    scores: np.ndarray
    fine: np.ndarray
    places: np.ndarray


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
    posteriors = found_by(measured.scores)
    write_atomically(folder / "statements.md", statements(folder))
    write_atomically(folder / "scores.md", scores_table(folder))
    write_atomically(folder / "choices.md", choices(folder))
    sample = measured.bodies[representative(posteriors[LEVELS.name], measured.places, SAMPLE)]
    readings = candidates(int(sample.max()) + 1)
    rows = [cells_of(readings[body], PRIOR) for body in sample]
    columns = {choice.name: [row[i] for row in rows] for i, choice in enumerate(PRIOR)}
    tables.write_csv(folder / "readings.csv", {"body": sample.tolist(), **columns})
    figure = posterior_figure(measured.places, posteriors, NAMED["study"], NAMED["program"])
    save_figure(figure, folder / "posterior.png")
    shares = {
        strictness.name: met(measured.scores, strictness.target).mean(axis=0)
        for strictness in STRICTNESS
    }
    words = [WORDS[name] for name in SCORES]
    figure = statements_figure(words, shares, meeting_ratio(measured.scores, LEVELS.target))
    save_figure(figure, folder / "statements.png")
    levels, near = posteriors[LEVELS.name], measured.scores
    named_scores = tables.read_csv(folder / "named.csv")
    figure = scores_figure(
        words,
        {
            "all readings": np.quantile(near, (0.05, 0.5, 0.95), axis=0),
            "posterior": np.array(
                [
                    [_quantile(values[levels.accepted], levels.weights, q) for values in near.T]
                    for q in (0.05, 0.5, 0.95)
                ]
            ),
        },
        {
            name: np.array([float(named_scores[score][k]) for score in SCORES])
            for k, name in enumerate(NAMED)
        },
        {f"met, {strictness.name}": strictness.target for strictness in STRICTNESS},
    )
    save_figure(figure, folder / "scores.png")


def statements(folder: Path) -> str:
    """Tabulate for each statement the readings that meet it, and the score from which on it is
    met."""
    scores = read(folder).scores
    counts = {strictness.name: met(scores, strictness.target) for strictness in STRICTNESS}
    rows = [["statement", *(f"meet it, {name}" for name in counts)]]
    for i, name in enumerate(SCORES):
        shares = [
            f"{counts[strictness.name][:, i].mean():.0%} (≥ {strictness.target[i]:.2g})"
            for strictness in STRICTNESS
        ]
        rows.append([WORDS[name], *shares])
    maxima = [f"{matches.sum(axis=1).max()} of {len(SCORES)}" for matches in counts.values()]
    return markdown_table([*rows, ["most that one reading meets", *maxima]])


def scores_table(folder: Path) -> str:
    """Tabulate for each statement the median score among all and the accepted readings, and the
    scores of the named ones."""
    measured = read(folder)
    scores, fine = measured.scores, measured.fine
    levels = found_by(scores)[LEVELS.name]
    named_scores = tables.read_csv(folder / "named.csv")
    rows = [["statement", "all", "posterior", "finely", *NAMED]]
    for i, name in enumerate(SCORES):
        inside = [
            _quantile(values[levels.accepted, i], levels.weights, 0.5) for values in (scores, fine)
        ]
        cells = [np.median(scores[:, i]), *inside, *map(float, named_scores[name])]
        rows.append([WORDS[name], *(f"{value:.2f}" for value in cells)])
    reference = np.array(
        [[float(named_scores[name][k]) for name in SCORES] for k in range(len(NAMED))]
    )
    finely = np.where(np.isfinite(fine).any(axis=1), shortfalls(fine, LEVELS.target), math.nan)
    inside = [
        _quantile(values[levels.accepted], levels.weights, 0.5)
        for values in (levels.distance, finely)
    ]
    far = [np.median(levels.distance), *inside, *shortfalls(reference, LEVELS.target)]
    rows.append([f"shortfall, {LEVELS.name}", *(f"{value:.2f}" for value in far)])
    return markdown_table(rows)


def choices(folder: Path) -> str:
    """Tabulate for each choice the middle and the 90 % range of the posterior, and how narrow it
    is."""
    measured = read(folder)
    scores, places = measured.scores, measured.places
    levels = found_by(scores)[LEVELS.name]
    criteria = [(LEVELS.name, share) for share in SHARES]
    criteria += [(strictness.name, SHARE) for strictness in STRICTNESS if strictness is not LEVELS]
    rows = [["choice", "prior", "posterior", *(f"{name}, {share:.1%}" for name, share in criteria)]]
    narrow = [narrowed(places, found_by(scores, share)[name]) for name, share in criteria]
    for i, choice in enumerate(PRIOR):
        position = places[levels.accepted, i]
        if choice.levels:
            weights = [
                levels.weights[np.isclose(position, choice.place(v))].sum() for v in choice.values
            ]
            labels = [_label(choice, value) for value in choice.values]
            prior = " / ".join(labels)
            inside = " / ".join(f"{weight:.0%}" for weight in weights)
        else:
            prior = " … ".join(_label(choice, value) for value in choice.values)
            low, middle, high = (_quantile(position, levels.weights, q) for q in (0.05, 0.5, 0.95))
            texts = [_label(choice, value_at(choice, float(x))) for x in (middle, low, high)]
            inside = f"{texts[0]} ({texts[1]} … {texts[2]})"
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


def _quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """Return a weighted quantile of the known values."""
    values, weights = values[~np.isnan(values)], weights[~np.isnan(values)]
    order = np.argsort(values)
    reached = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][min(int(np.searchsorted(reached, share)), len(values) - 1)])


if __name__ == "__main__":
    main(measure, show)
