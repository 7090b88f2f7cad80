"""`python -m research.tuning`: search for the settings of a learning algorithm."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import pandas as pd

from research.tuning.spaces import space_of
from research.tuning.task import BUDGET_S, FIRST_SEED, TuningTask
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import require_count
from tegotae._support.files import output_file, write_atomically
from tegotae.api.experiments import ExperimentOptions, adjusted, experiment_named, option_defaults
from tegotae.api.parameters import Values, in_shell
from tegotae.api.results import Table, short
from tegotae.parts.fields import replace
from tegotae.systems.registry import is_reference, name_of
from tegotae.training.settings import agents, settings_named

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

    from research.tuning.record import Confirmation, TunedSettings

_FRESH_SEEDS = 10_000
"""Distance of the seeds of the confirmation from those of the search."""


@dataclass(frozen=True, repr=False, kw_only=True)
class Tuning(Table):
    """Results of a search."""

    found: TunedSettings
    ranked: list[FrozenTrial]
    """The completed trials, the best first."""
    confirmed: Confirmation | None = None

    @property
    def table(self) -> pd.DataFrame:
        """The trials and their fitness, the best first."""
        return pd.DataFrame(
            [{"trial": t.number, "fitness": t.value} | t.params for t in self.ranked]
        )

    def texts(self) -> list[pd.DataFrame]:
        best = pd.Series(self.found["settings"], name="best").map(short).rename_axis("setting")
        return [self.table.head(10).map(short).set_index("trial"), best.to_frame()]

    def sentences(self) -> list[str]:
        """Return the counts of trials, and the confirmation."""
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

    def to_dict(self) -> JsonObject:
        return as_json(self.found)


def _values(model: str = "", **parts: Any) -> Values:
    """Return the values of a model's own experiment."""
    names = ("budget", "oscillator", "body", "fitness")
    overrides = {name: x for name, x in parts.items() if name in names}
    return option_defaults(experiment_named(model, **overrides))


@in_shell(defaults=_values, pictures=False)
def search(
    model: str,
    *others: str,
    storage: Path = Path("tuning.journal"),
    algorithm: str = "pgpe",
    trials: int = 50,
    seeds: int = 4,
    workers: int = 1,
    simulated_s: float = BUDGET_S,
    confirm: int = 4,
    restart: bool = False,
    keep: Path | None = None,
    **options: Unpack[ExperimentOptions],
) -> Table:
    """Search for an algorithm's settings (extra "tune"); run it again to continue after a stop.

    Settings are compared by their mean fitness over all models.

    Args:
        model: a recipe, such as ART or AR@quadruped-c, or an experiment of your own.
        others: further ones.
        storage: file that keeps every trial, an Optuna journal.
        algorithm: learning algorithm: a name such as pgpe, or your own, FILE.py:OBJECT.
        trials: number of settings to evaluate, including those of earlier calls.
        seeds: number of trainings per model and setting.
        workers: number of processes that train at the same time; each has its share of the cores.
        simulated_s: simulated time of one training [s], the same for every algorithm.
        confirm: number of fresh seeds for a comparison of the best settings with the first ones; 0
            for none.
        restart: start again, and move an existing tuning to a file beside this one.
        keep: write the best settings, with their origin, to this file (.json).
    """
    from research.tuning import describe, evaluate_settings, tune
    from research.tuning.record import confirmation, ranking, tried_first

    algorithm = algorithm_name(algorithm)
    space = space_of(algorithm)
    require_count("confirm", confirm, least=0)
    if keep is not None:
        output_file(keep)
    given = {"algorithm": algorithm, "seeds": seeds, "simulated_s": simulated_s, **options}
    task = task_of([model, *others], given)
    try:
        searched = tune(algorithm, task, storage, trials=trials, workers=workers, restart=restart)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; {storage} keeps what was tried, the same command goes on"
        ) from None
    document, ranked = describe(algorithm, task, space, searched), ranking(searched)
    confirmed = None
    if confirm:
        fresh = dataclasses.replace(task, seeds=confirm, first_seed=FIRST_SEED + _FRESH_SEEDS)
        settings = [tried_first(space), space.suggest(ranked[0])]
        confirmed = confirmation(fresh, *evaluate_settings(space, settings, fresh, workers=workers))
        document["found"]["confirmation"] = confirmed
    if keep is not None:
        write_atomically(keep, json.dumps(document, indent=1) + "\n")
    tuning = Tuning(found=document, ranked=ranked, confirmed=confirmed)
    return dataclasses.replace(tuning, notes=tuning.sentences())


def algorithm_name(algorithm: str) -> str:
    """Return the algorithm's name; one of a user's file is known by it then."""
    if not is_reference(algorithm):
        return algorithm
    return name_of(type(settings_named(algorithm)))


_PARTS = ("oscillator", "body", "fitness")


def task_of(models: Sequence[str], options: Mapping[str, Any]) -> TuningTask:
    """Return the trainings on which settings are evaluated.

    Args:
        models: names of the experiments.
        options: options of `search`.
    """
    parts = {x: options.get(x) for x in _PARTS}
    values = {name: x for name, x in options.items() if name in _OPTIONS}
    values |= {x: options[x] for x in _PARTS if isinstance(options.get(x), Mapping)}
    budget = options.get("budget")
    trainings = [adjusted(experiment_named(x, budget=budget, **parts), values) for x in models]
    if options["algorithm"] in agents():  # whose reward has no ΔΩ: they are evaluated without it
        trainings = [replace(x, {"objective": x.objective.without_frequency()}) for x in trainings]
    seconds = options["simulated_s"]
    return TuningTask(experiments=tuple(trainings), seeds=options["seeds"], budget_s=seconds)


_OPTIONS = (
    *("height_m", "duration_s", "tick_s", "hold"),
    *("cot_only", "vary", "episodes_per_candidate"),
)


def _words(estimate: Mapping[str, float]) -> str:
    return f"{estimate['mean']:.4f} [{estimate['low']:.4f}, {estimate['high']:.4f}]"
