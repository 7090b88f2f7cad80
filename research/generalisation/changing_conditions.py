"""Training under changing conditions: what it costs undisturbed, and what it gains.

    python -m research.generalisation.changing_conditions STUDY --out FOLDER

trains some models of the paper under changing conditions, goes on where it was stopped, and tries
them beside the same models of a study, which were trained in always the same episode.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from research.frame import Place, main, markdown_table, with_interval, write_rows, write_text
from research.generalisation.run import STUDIED
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import (
    MEASURES,
    Done,
    Retention,
    generalise,
)
from tegotae.figures.generalisation import groups_figure
from tegotae.figures.style import save_figure
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.statistics import interval
from tegotae.simulation.world import Uniform
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.training.collection import read_runs
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned

KEPT = Path(__file__).parents[2] / "research" / "generalisation"
MODELS = ("V-sector-w8", "VG-gF-sector-w8", "ART-rF-tphif-w8", "T-Fv", "ARGT-rF-gF-tphif-w8")
SEEDS = tuple(range(8))
EPISODES = 4
STOPPING = Stopping(generations=120, least=240)
"""The rule of the kept study with an earlier cap: half of its least generations, of four episodes a
candidate; twice the episodes that the study's trainings took."""
CONDITIONS = (
    Uniform("mass_kg", low=0.08, high=0.12),
    Uniform("stiffness_n_per_m", low=4.0, high=6.0),
    Uniform("damping_ns_per_m", low=0.1, high=0.3),
    Uniform("height_m", low=1.05, high=1.4),
    Uniform("drop_m", low=-0.1, high=0.25, from_s=10.0),
)
TRAINED = {"steady": "always the same episode", "varied": "changing conditions"}
"""Kinds of training, by their names in the tables."""
SEEN = ("mass", "stiffness", "damping", "release", "step", "omega")
"""Disturbances of a kind that was met in training."""


def run(study: Place, out: Path) -> None:
    """Train, disturb, and write the tables and figures of the page.

    Args:
        study: folder of the study.
        out: folder of the trainings and results.
    """
    steady = {runs.name: runs for runs in read_runs(study)}
    pairs, controllers = [], []
    for name in MODELS:
        baseline = steady[name]
        baseline = dataclasses.replace(
            baseline, weights=baseline.weights[: len(SEEDS)], labels=baseline.labels[: len(SEEDS)]
        )
        folder = out / "training" / name
        train(run_of(varied(recipe(name).experiment())), folder)
        (retrained,) = read_runs(folder)
        pairs.append((baseline, retrained))
        controllers += [
            ControllersUnderTest.from_runs(baseline),
            ControllersUnderTest.from_runs(retrained),
        ]
    outcomes = generalise(controllers, STUDIED, out / "trials")
    tables(outcomes, pairs)


def varied(experiment: Experiment) -> Experiment:
    """Return an experiment under changing conditions."""
    conditions = CONDITIONS
    if experiment.omega is not None:
        near = (0.85 * experiment.omega, 1.15 * experiment.omega)
        conditions = (*conditions, Uniform("omega", low=near[0], high=near[1]))
    return dataclasses.replace(
        experiment, name=f"{experiment.name}+varied", conditions=conditions, episodes=EPISODES
    )


def run_of(experiment: Experiment) -> Run:
    """Return a training of it, by the settings of the kept study."""
    return Run(
        experiment=experiment,
        seeds=SEEDS,
        learner=Evolution(algorithm=tuned("pgpe"), stopping=STOPPING),
    )


def tables(results: Sequence[Done], pairs) -> None:
    """Write what it costs, what it gains, and the curves."""
    protocol = Protocol(offsets=(0.0,), drop_m=0.0)
    rows = []
    for pair in pairs:
        for training, runs in zip(TRAINED, pair, strict=True):
            sets = np.unique(runs.weights, axis=0)  # a search has one outcome, whatever the seed
            table = evaluate(
                runs.controller, sets, runs.omega, runs.body, protocol,
                metrics=["cot_inverse", "limit_cycle_share"],
            ).runs()  # fmt: skip
            cot = interval(table["cot_inverse"])
            rows.append(
                {"model": pair[0].name, "trained": training, "runs": len(sets)}
                | {"limit_cycle_share": float(table["limit_cycle_share"].mean())}
                | {"cot_inverse": cot.mean, "low": cot.low, "high": cot.high}
            )
    write_rows(KEPT / "undisturbed.csv", rows, digits=3)
    write_text(KEPT / "undisturbed.md", undisturbed_text(rows))
    outcomes = {tested.name: (tested, outcome) for tested, outcome in results}
    write_overall(results, pairs)
    for name in ("ART-rF-tphif-w8", "T-Fv"):
        groups = {f"{name}, always the same episode": [outcomes[name]]}
        groups[f"{name}, changing conditions"] = [outcomes[f"{name}+varied"]]
        file = f"varied_{name.partition('-')[0]}.png"
        save_figure(groups_figure(groups, STUDIED), KEPT / file)


def write_overall(results: Sequence[Done], pairs) -> None:
    """Write the mean share of levels at which a run still hops, and keeps its gait, over runs."""
    outcomes = {tested.name: outcome for tested, outcome in results}
    lines = []
    for steady, varied in pairs:
        for in_training in (True, False):
            for training, runs in zip(TRAINED, (steady, varied), strict=True):
                cells = [
                    _over_levels(outcomes[runs.name], in_training, measure)
                    for measure in ("moves", "keeps")
                ]
                label = "seen" if in_training else "never seen"
                lines.append([steady.name, TRAINED[training], label, *cells])
    head = ("model", "trained", "conditions", "still hops", "keeps its gait")
    write_text(KEPT / "overall.md", markdown_table([head, *lines]))


def _over_levels(outcome: Retention, in_training: bool, measure: str) -> str:
    """Return the mean over runs, and its interval, of the share of a run's levels."""
    table = outcome.table[outcome.table[MEASURES[measure]]]
    table = table[table["condition"].isin(SEEN) == in_training]
    if measure == "keeps":
        table = table[table["condition"] != "noise"]  # under which no hop is like the last
    shares = table.groupby("run")[measure].mean()
    return with_interval(shares, within=(0.0, 1.0))


def undisturbed_text(rows: Sequence[dict]) -> str:
    """Tabulate the results of each training on the usual body, in Markdown."""
    lines = [
        (
            row["model"],
            TRAINED[row["trained"]],
            row["runs"],
            f"{row['limit_cycle_share']:.2f}",
            f"{row['cot_inverse']:.3f}{_interval(row)}",
        )
        for row in rows
    ]
    head = ("model", "trained", "runs", "on a limit cycle", "CoT⁻¹ [m/J]")
    return markdown_table([head, *lines])


def _interval(row: dict) -> str:
    """Return the interval of a mean, or nothing for a single run."""
    return "" if np.isnan(row["low"]) else f" [{row['low']:.3f}, {row['high']:.3f}]"


if __name__ == "__main__":
    main(run)
