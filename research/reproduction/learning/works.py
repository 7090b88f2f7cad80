"""Equal comparisons by other definitions of work: in the study's body, and in 24 others.

    python -m research.reproduction.learning.works readings  # 24 bodies, three works, 20 min of CPU
    python -m research.reproduction.learning.works bodies    # two bodies, over an hour of CPU
    python -m research.reproduction.learning.works report    # the table of the 24 bodies

Each continues where it was stopped. `research.reproduction contrasts` compares the tables of
`bodies` like those of fifteen runs. Plan, made before the runs:

- All is trained by the study's algorithm to its plateau, for the fitness of its own definition of
  work, and judged by it from the common releases, as `research.reproduction.learning.contrasts`
  says. Whatever is chosen is chosen on the first half of them and judged on the other half.
- `bodies`: positive and net work in the study's body, and absolute work in the calibrated body,
  where it is not known which episodes of the fifteen runs follow ω; its rows of all episodes repeat
  those of fifteen. At seven ω_t V's three drives, twelve designs of learned feedback, three runs
  each in place of fifteen, and the six laws by differential evolution. A chosen run is one of
  three. Runs matter little to the intervals, which are over designs and ω_t. Laws that are trained,
  and those by CMA-ES, are left out. Computers allow less than planned, so V and the four designs on
  φ and f come first, then the laws, and the other designs as time allows. Only designs with all ω_t
  count. (This order was fixed after the first runs at positive work, before any comparison.)
- `readings`: the 24 readings of `research.reproduction.readings`, each by all three definitions, so
  that body and work no longer vary together. V's three drives, and AR and ART with an actuation on
  φ and f, one run each at 4 and 8 rad/s; ARG and ARGT follow in all bodies as time allows, and do
  not count unless all bodies have them. Bodies differ in the scale of CoT⁻¹, so a body's number is
  the gain (L - V) / max(L, V), mean over ω_t, with L the mean of the designs and V the best V.
  Intervals are Student's over bodies, and over paired differences between works in the same body.
  The statement "work decides as much as the body" holds if the standard deviation of gains between
  the works of a body is at least that between bodies by one work. (Added when sixteen bodies were
  seen: the same without net work.)
"""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import Row, Table, main, markdown_table, write_text
from research.reproduction.claims.random_effects import crossed
from research.reproduction.learning.contrasts import DESIGN, chosen, merits
from research.reproduction.learning.judged import judge_runs
from research.reproduction.learning.runs import run_rows, searched_rows, where
from research.reproduction.learning.searched import SearchedLaw, trained
from research.reproduction.plan import plan
from research.reproduction.readings.designs import calibrated_readings
from research.reproduction.readings.experiment import experiment_under
from research.reproduction.readings.named import CALIBRATED, STUDY, reading_named
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.systems.term_sets import ShortLaw
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run
from tegotae.training.scoring import best_gain
from tegotae.training.settings import tuned

KEPT = Path("research/reproduction/kept/learning")
READINGS = Table(KEPT / "works.csv", ("body", "work", "model"))
WORKS = ("absolute", "positive", "net")
RUNS = 3
"""Runs of a design in the study's body and the calibrated one."""
FIRST = ("V-sector", "V-reflex", "V-both", "AR-rF-both", "ART-rF-tphif")
SECOND = ("ARG-rF-gF-both", "ARGT-rF-gF-tphif")
"""Controllers in the 24 bodies, without their ω_t."""


def rows_of(experiment: Experiment, runs: int) -> list[Row]:
    """Train or search an experiment, and return the rows of its runs."""
    if isinstance(recipe(experiment.name).terms, ShortLaw):
        law = SearchedLaw(experiment)
        evolved = law.evolved()
        arrays = judge_runs(experiment, evolved.x[None].astype("float32"), whole_alone=True)
        table = searched_rows(law, arrays | {"best_fitness": np.array([-evolved.fun])})
        return table.to_dict("records")
    if experiment.is_searched:
        gain, fitness = best_gain(experiment)
        weights, best = np.array([[gain]]), np.array([fitness])
    else:
        learner = Evolution(algorithm=tuned("pgpe"))
        progress = trained(Run(experiment=experiment, learner=learner, seeds=tuple(range(runs))))
        weights, best = np.asarray(progress.best_weights), np.asarray(progress.best_fitness)
    arrays = judge_runs(experiment, weights.astype("float32"), whole_alone=True)
    return run_rows(experiment, best, arrays).to_dict("records")


def bodies() -> None:
    """Measure the controllers of all contrasts in both bodies."""
    tables = {
        "study-positive": (STUDY, "positive"),
        "study-net": (STUDY, "net"),
        "calibrated-locked": (CALIBRATED, "absolute"),
    }
    planned = [e for e in plan("learning").experiments if not e.name.startswith(("VG", "VT"))]
    for stage in range(4):
        for file, (reading, work) in tables.items():
            options = dataclasses.replace(reading_named(reading), work=work)
            by_name = {e.name: options.applied(e) for e in planned if _stage(e.name) == stage}
            table = Table(KEPT / f"{file}.csv", ("model",))
            cells = [(name,) for name in by_name]
            table.measure(cells, lambda name, models=by_name: rows_of(models[name], RUNS))


def _stage(name: str) -> int:
    """Return the turn of a model: V, designs on φ and f, short laws, all others."""
    if name.startswith("V"):
        return 0
    if isinstance(recipe(name).terms, ShortLaw):
        return 2
    return 1 if "-both-" in name or "-tphif-" in name else 3


def readings() -> None:
    """Measure the 24 bodies by all definitions of work."""
    sample = calibrated_readings(24)

    def rows(body: int, work: str, model: str) -> list[Row]:
        reading = dataclasses.replace(sample[body], work=work)
        measured = rows_of(experiment_under(reading, recipe(model)), 1)
        return [{"body": body, "work": work} | row for row in measured]

    for models in (FIRST, SECOND):
        names = [f"{model}-w{omega}" for model in models for omega in (4, 8)]
        cells = itertools.product(range(len(sample)), WORKS, names)
        READINGS.measure(cells, rows)


def gains(runs: pd.DataFrame) -> pd.DataFrame:
    """Return the gain of learned feedback over the best V, bodies by works; NaN if unfinished."""
    first = runs.model.str.startswith(FIRST)
    complete = (~first).sum() == 24 * len(WORKS) * 2 * len(SECOND)
    runs = runs if complete else where(runs, first)
    values, models = {}, runs.model.nunique()
    for key, rows in runs.groupby(["body", "work"]):
        vanilla, learned = (x for _, x in rows.groupby(rows.architecture != "V"))
        best = merits(chosen(vanilla, "merit", ["omega_t"]), "merit", ["senses"]).to_numpy()[0]
        mean = merits(learned, "merit", DESIGN).to_numpy().mean(axis=0)
        gain = (mean - best) / np.maximum(np.maximum(mean, best), 1e-9)
        values[key] = gain.mean() if len(rows) == models else np.nan
    return pd.DataFrame(pd.Series(values).unstack()[list(WORKS)])


def works_table(by_work: pd.DataFrame) -> str:
    """Return the gains over all bodies by work, and their paired differences."""
    heads = ("work", "bodies", "gain", "minus absolute", "learned better", "V better")
    rows: list[list[object]] = [list(heads)]
    for work in WORKS:
        gain = by_work[work].to_numpy()
        gain, change = (x[np.isfinite(x)] for x in (gain, gain - by_work["absolute"].to_numpy()))
        cells = [_interval(gain), "–" if work == "absolute" else _interval(change)]
        rows.append([work, len(gain), *cells, (gain > 0).sum(), (gain < 0).sum()])
    spread: list[list[object]] = [["standard deviation of gains", "three works", "without net"]]
    for name, axis in (("between the works of a body", 1), ("between bodies by one work", 0)):
        paired = by_work.dropna().to_numpy()
        spread.append([name, *(f"{paired[:, :n].std(axis, ddof=1).mean():.2f}" for n in (3, 2))])
    return f"{markdown_table(rows)}\n{markdown_table(spread)}"


def _interval(values: np.ndarray) -> str:
    """Return the mean over bodies with Student's interval."""
    low, high = crossed(values[None])
    return f"{values.mean():+.2f} [{low:+.2f}, {high:+.2f}]"


def report() -> None:
    """Write the table of the 24 bodies."""
    write_text(KEPT / "works.md", works_table(gains(READINGS.read())))


if __name__ == "__main__":
    main(readings, bodies, report)
