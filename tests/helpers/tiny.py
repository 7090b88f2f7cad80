"""The smallest training that is one: seconds, not minutes. The tests share its compiled program."""

import csv
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from tegotae import Timing
from tegotae.cli import main
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.fields import replace
from tegotae.systems import controller_file
from tegotae.systems.recipe import recipe
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import tuned

SEEDS = (0, 1)
GENERATIONS = 4
OPTIONS = (
    *("ART", "--budget", "20", "--seeds", "2", "--population", "8"),
    *("--duration-s", "3", "--settle-s", "1"),
)
"""Options of `tegotae train`, but for the generations and the folder."""

SETTINGS: dict[str, Any] = {
    "timing": Timing(duration_s=3.0, tick_s=0.002),
    "objective": Fitness(settle_s=1.0),
}
"""Settings of an experiment's episode."""
RUN = Run(
    experiment=recipe("ART").experiment(budget=20, **SETTINGS),
    seeds=SEEDS,
    learner=Evolution(
        algorithm=dataclasses.replace(tuned("pgpe"), population=8),
        stopping=Stopping(generations=GENERATIONS),
    ),
)
"""The same for `tegotae.training.run.train`."""


def changed(run: Run = RUN, **settings: Any) -> Run:
    """The training with other settings of its experiment."""
    return dataclasses.replace(run, experiment=replace(run.experiment, settings))


def run_of(generations: int) -> Run:
    """The training with another number of generations."""
    learner = dataclasses.replace(RUN.learner, stopping=Stopping(generations=generations))
    return dataclasses.replace(RUN, learner=learner)


def train(out: Path, *extra: str, generations: int = GENERATIONS) -> int:
    """Call `tegotae train`; its exit status."""
    return main(["train", *OPTIONS, "--generations", str(generations), "--out", str(out), *extra])


def controllers(folder: Path) -> list[Path]:
    """The controller files, in the order of the seeds."""
    return [folder / f"ART-rF-tphif-w8-seed{seed}.json" for seed in SEEDS]


def learned(folder: Path) -> dict[str, Any]:
    """All the numbers that a training ended in."""
    with np.load(folder / "checkpoint.npz", allow_pickle=False) as stored:
        checkpoint = {name: stored[name].tolist() for name in stored.files}
    saved = [controller_file.load(path) for path in controllers(folder)]
    return {
        "checkpoint": checkpoint,
        "curves": list(csv.reader((folder / "curves.csv").open())),
        "weights": [single.weights.tolist() for single in saved],
        "training": [single.training for single in saved],
        "configuration": json.loads((folder / "run.json").read_text())["configuration"],
    }


def contents(folder: Path) -> dict[str, bytes]:
    """Every file in a folder, but for its lock."""
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and p.name != ".lock"
    }
