"""`python -m studies.tuning`: search for the settings of a learning algorithm."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from studies.tuning.spaces import space_of
from studies.tuning.task import BUDGET_S, FIRST_SEED, TuningTask
from tegotae._support.errors import require_count
from tegotae._support.files import output_file, write_atomically
from tegotae.cli.console import print_rows
from tegotae.cli.options import UNSET, ExperimentOptions, experiment_named
from tegotae.systems.grammar import BUDGET
from tegotae.systems.registry import name_of
from tegotae.systems.user_objects import is_reference
from tegotae.training.settings import agents, settings_named

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

    from studies.tuning.record import Confirmation, TunedSettings

_FRESH_SEEDS = 10_000
"""How far the seeds of the confirmation lie from those of the search."""


@dataclass(frozen=True, kw_only=True)
class Tune(ExperimentOptions):
    """Search for an algorithm's settings (extra "tune"); run it again to continue after a stop."""

    models: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Models (see `tegotae models`), or experiments of your own, FILE.py:OBJECT. Settings are
    compared by their mean fitness over all of them."""
    storage: Path
    """File that keeps every trial, an Optuna journal."""
    algorithm: str = "pgpe"
    """Learning algorithm: a name such as pgpe, or your own, FILE.py:OBJECT."""
    trials: int = 50
    """Number of settings to evaluate, including those of earlier calls."""
    seeds: int = 4
    """Number of trainings per model and setting."""
    workers: int = 1
    """Number of processes that train at the same time; each has its share of the cores."""
    budget_s: float = BUDGET_S
    """Simulated time of one training [s], the same for every algorithm."""
    confirm: int = 4
    """Number of fresh seeds for a comparison of the best settings with the first ones; 0 for
    none."""
    anew: bool = False
    """Start again, and move an existing tuning to a file beside this one."""
    keep: Annotated[Path | None, UNSET] = None
    """Write the best settings, with their origin, to this file (.json)."""
    budget: Annotated[int | None, tyro.conf.arg(help_behavior_hint=f"(default: {BUDGET})")] = None
    """Maximum number of trained parameters of a model."""

    def run(self) -> None:
        """Search, and print what was found."""
        from studies.tuning import describe, evaluate_settings, tune
        from studies.tuning.record import confirmation, ranking, tried_first

        algorithm = self._algorithm()
        space = space_of(algorithm)
        require_count("confirm", self.confirm, least=0)
        if self.keep is not None:
            output_file(self.keep)
        task = self.task
        try:
            trials = tune(
                algorithm,
                task,
                self.storage,
                trials=self.trials,
                workers=self.workers,
                anew=self.anew,
            )
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted; {self.storage} keeps what was tried, the same command goes on"
            ) from None
        document = describe(algorithm, task, space, trials)
        ranked = ranking(trials)
        _print(document, ranked)
        if self.confirm:
            fresh = dataclasses.replace(
                task, seeds=self.confirm, first_seed=FIRST_SEED + _FRESH_SEEDS
            )
            settings = [tried_first(space), space.suggest(ranked[0])]
            found = evaluate_settings(space, settings, fresh, workers=self.workers)
            confirmed = confirmation(fresh, *found)
            document["found"]["confirmation"] = confirmed
            _print_confirmation(confirmed)
        if self.keep is not None:
            write_atomically(self.keep, json.dumps(document, indent=1) + "\n")
            print(f"wrote {self.keep}")

    def _algorithm(self) -> str:
        """The algorithm's name; one of a user's file is known by it then."""
        if not is_reference(self.algorithm):
            return self.algorithm
        return name_of(type(settings_named(self.algorithm)))

    @property
    def task(self) -> TuningTask:
        """What settings are evaluated on."""
        experiments = [
            self.applied(experiment_named(name, self.budget), self.budget) for name in self.models
        ]
        if (
            self._algorithm() in agents()
        ):  # whose reward has no ΔΩ, and so they are evaluated without
            experiments = [
                each.replaced(objective=each.objective.without_frequency()) for each in experiments
            ]
        return TuningTask(experiments=tuple(experiments), seeds=self.seeds, budget_s=self.budget_s)


def _print(document: TunedSettings, ranked: list[FrozenTrial]) -> None:
    """The best trials, and the settings of the best."""
    parameters = list(ranked[0].params)
    print_rows(
        ("trial", "fitness", *parameters),
        (
            (str(t.number), f"{t.value:.4f}", *(f"{t.params[name]:.4g}" for name in parameters))
            for t in ranked[:10]
        ),
    )
    counts = ", ".join(f"{count} {state}" for state, count in document["found"]["trials"].items())
    print(f"trials: {counts}; the best settings:")
    for name, value in document["settings"].items():
        print(f"  {name} = {value:.4g}" if isinstance(value, float) else f"  {name} = {value}")


def _print_confirmation(found: Confirmation) -> None:
    def show(i: Mapping[str, float]) -> str:
        return f"{i['mean']:.4f} [{i['low']:.4f}, {i['high']:.4f}]"

    print(
        f"on {found['seeds']} fresh seeds per model: {show(found['best'])}, with the settings "
        f"tried first {show(found['tried_first'])}, difference {show(found['difference'])}"
    )
