"""`python -m studies.tuning`: search for the settings of a learning algorithm."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from studies.tuning.spaces import space_of
from studies.tuning.task import BUDGET_S, FIRST_SEED, TuningTask
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import require_count
from tegotae._support.files import output_file, write_atomically
from tegotae.questions.answer import AnswerBase, short
from tegotae.questions.experiments import ExperimentOptions, Experiments
from tegotae.questions.question import question
from tegotae.systems.experiment import Experiment
from tegotae.systems.registry import name_of
from tegotae.systems.user_objects import is_reference
from tegotae.training.settings import agents, settings_named

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

    from studies.tuning.record import Confirmation, TunedSettings

_FRESH_SEEDS = 10_000
"""Distance of the seeds of the confirmation from those of the search."""


@dataclass(frozen=True, kw_only=True)
class TuningOptions:
    """Options of a search: its length, and the trainings."""

    storage: Path = Path("tuning.journal")
    """File that keeps every trial, an Optuna journal."""
    algorithm: str = "pgpe"
    """Learning algorithm: a name such as pgpe, or your own, FILE.py:OBJECT."""
    trials: int = 50
    """Number of settings to evaluate, including those of earlier calls."""
    seeds: int = 4
    """Number of trainings per model and setting."""
    workers: int = 1
    """Number of processes that train at the same time; each has its share of the cores."""
    simulated_s: float = BUDGET_S
    """Simulated time of one training [s], the same for every algorithm."""
    confirm: int = 4
    """Number of fresh seeds for a comparison of the best settings with the first ones; 0 for
    none."""
    anew: bool = False
    """Start again, and move an existing tuning to a file beside this one."""
    keep: Path | None = None
    """Write the best settings, with their origin, to this file (.json)."""
    experiment: ExperimentOptions

    @classmethod
    def options_of(cls, experiment: Experiment) -> TuningOptions:
        """An experiment's own values."""
        return cls(experiment=ExperimentOptions.options_of(experiment))

    @property
    def algorithm_name(self) -> str:
        """The algorithm's name; one of a user's file is known by it then."""
        if not is_reference(self.algorithm):
            return self.algorithm
        return name_of(type(settings_named(self.algorithm)))


@dataclass(frozen=True, repr=False)
class Tuning(AnswerBase):
    """Results of a search."""

    found: TunedSettings
    ranked: list[FrozenTrial]
    """The completed trials, the best first."""
    confirmed: Confirmation | None = None

    def frame(self) -> pd.DataFrame:
        """The trials and their fitness, the best first."""
        return pd.DataFrame(
            [{"trial": t.number, "fitness": t.value} | t.params for t in self.ranked]
        )

    def texts(self) -> list[pd.DataFrame]:
        best = pd.Series(self.found["settings"], name="best").map(short).rename_axis("setting")
        return [self.frame().head(10).map(short).set_index("trial"), best.to_frame()]

    @property
    def notes(self) -> list[str]:
        counts = self.found["found"]["trials"].items()
        notes = ["trials: " + ", ".join(f"{count} {state}" for state, count in counts)]
        if self.confirmed:
            best, first, gain = (
                _words(self.confirmed[key]) for key in ("best", "tried_first", "difference")
            )
            notes.append(
                f"on {self.confirmed['seeds']} fresh seeds per model: {best}, with the settings "
                f"tried first {first}, difference {gain}"
            )
        return notes

    def document(self) -> JsonObject:
        return as_json(self.found)


@question(
    subjects=Experiments, several=True, kinds={"One leg": "ART", "Several legs": "AR@quadruped-c"}
)
def search(experiments: Sequence[Experiment], options: Sequence[TuningOptions]) -> Tuning:
    """Search for an algorithm's settings (extra "tune"); run it again to continue after a stop.

    Settings are compared by their mean fitness over all models.
    """
    from studies.tuning import describe, evaluate_settings, tune
    from studies.tuning.record import confirmation, ranking, tried_first

    first = options[0]
    algorithm = first.algorithm_name
    space = space_of(algorithm)
    require_count("confirm", first.confirm, least=0)
    if first.keep is not None:
        output_file(first.keep)
    task = task_of(experiments, options)
    try:
        trials = tune(
            algorithm,
            task,
            first.storage,
            trials=first.trials,
            workers=first.workers,
            anew=first.anew,
        )
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; {first.storage} keeps what was tried, the same command goes on"
        ) from None
    document, ranked = describe(algorithm, task, space, trials), ranking(trials)
    confirmed = None
    if first.confirm:
        fresh = dataclasses.replace(task, seeds=first.confirm, first_seed=FIRST_SEED + _FRESH_SEEDS)
        settings = [tried_first(space), space.suggest(ranked[0])]
        confirmed = confirmation(
            fresh, *evaluate_settings(space, settings, fresh, workers=first.workers)
        )
        document["found"]["confirmation"] = confirmed
    if first.keep is not None:
        write_atomically(first.keep, json.dumps(document, indent=1) + "\n")
    return Tuning(document, ranked, confirmed)


def task_of(experiments: Sequence[Experiment], options: Sequence[TuningOptions]) -> TuningTask:
    """Return the task that settings are evaluated on."""
    first = options[0]
    experiments_of_task = [
        option.experiment.applied(experiment)
        for experiment, option in zip(experiments, options, strict=True)
    ]
    if first.algorithm_name in agents():  # whose reward has no ΔΩ: they are evaluated without it
        experiments_of_task = [
            x.replaced(objective=x.objective.without_frequency()) for x in experiments_of_task
        ]
    return TuningTask(
        experiments=tuple(experiments_of_task), seeds=first.seeds, budget_s=first.simulated_s
    )


def _words(estimate: Mapping[str, float]) -> str:
    return f"{estimate['mean']:.4f} [{estimate['low']:.4f}, {estimate['high']:.4f}]"
