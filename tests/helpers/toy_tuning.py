"""A search space whose trainings take no time, for tests of the search around them."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from research.tuning import (
    SPACES,
    Space,
    TuningTask,
    tune,
)
from tegotae._support.errors import TegotaeError
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe

TASK = TuningTask(experiments=(recipe("ART").experiment(), recipe("AR").experiment()), seeds=4)
"""Eight trainings a trial."""


@dataclass(frozen=True)
class Toy:
    """Settings of nothing."""

    x: float


def suggest(trial) -> Toy:
    return Toy(trial.suggest_float("x", -4.0, 4.0))


def parabola(
    settings: Toy, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    """Best at x = 1; every training has a level of its own, which is larger than what x does."""
    level = 100.0 * (experiment.name == recipe("AR").name)
    return [level + seed % 7 - (settings.x - 1.0) ** 2 for seed in seeds]


def dying(
    settings: Toy, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    """The process ends in the second half of a trial, as one that is out of memory does."""
    if seeds[0] > task.first_seed:
        os._exit(9)
    return parabola(settings, task, experiment, seeds)


def refusing(
    settings: Toy, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    raise TegotaeError("x is out of the question")


def waiting(
    settings: Toy, task: TuningTask, experiment: Experiment, seeds: tuple[int, ...]
) -> list[float]:
    """Well into the third trial it says so, and waits for the file `release` to be closed."""
    fitness = parabola(settings, task, experiment, seeds)
    place = Path(os.environ["TOY_RELEASE"])
    counter = place.with_name("jobs")
    with counter.open("a") as jobs:
        jobs.write(".")
    if counter.stat().st_size == 10:
        print("waiting", flush=True)
        place.read_bytes()
    return fitness


def space(learn=parabola) -> Space:
    return Space(suggest=suggest, learn=learn, first={"x": 0.0}, seeds_at_once=2)


if __name__ == "__main__":
    import toy_tuning  # under this name the worker finds its functions

    SPACES["toy"] = toy_tuning.space(toy_tuning.waiting)
    tune("toy", toy_tuning.TASK, Path(sys.argv[1]), trials=5)
