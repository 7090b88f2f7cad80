"""`tegotae tune`: search for the settings of a learning algorithm."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from tegotae.cli.options import UNSET
from tegotae.cli.tables import print_rows
from tegotae.errors import require_count, unknown
from tegotae.files import output_file, write_atomically
from tegotae.models import BUDGET, find
from tegotae.rollout import Timing
from tegotae.training.fitness import EPISODE, SETTLE_S, Fitness
from tegotae.training.learners import agents
from tegotae.tuning.spaces import SPACES
from tegotae.tuning.task import BUDGET_S, FIRST_SEED, Task

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

_FRESH_SEEDS = 10_000
"""How far the seeds of the confirmation lie from those of the search."""


@dataclass(frozen=True)
class Tune:
    """Search for an algorithm's settings (extra "tune"); the same command goes on after a stop."""

    models: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Models to do well on (see `tegotae models`): settings are judged by their mean fitness."""
    storage: Path
    """File that keeps every trial: an Optuna journal."""
    algorithm: str = "pgpe"
    """Whose settings."""
    trials: int = 50
    """Settings to judge, those of earlier calls included."""
    seeds: int = 4
    """Trainings of each model per setting."""
    workers: int = 1
    """Processes that train at the same time, each with its share of the cores."""
    budget_s: float = BUDGET_S
    """Simulated time that one training may spend [s], the same for every algorithm."""
    confirm: int = 4
    """Fresh seeds on which the best settings are compared with those tried first; 0 for none."""
    keep: Annotated[Path | None, UNSET] = None
    """Write the best settings, with how they were found, to this file (.json)."""
    duration: float = EPISODE.duration_s
    """Length of an episode [s]."""
    tick: float = EPISODE.tick_s
    """Control period [s]."""
    settle: float = SETTLE_S
    """Time in an episode before it is judged [s]."""
    energy: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    cot_only: bool = False
    """Judge CoT⁻¹ alone, without ΔΩ, as in the paper's comparison of algorithms (agents always)."""
    budget: int = BUDGET
    """Largest number of trained parameters."""

    def run(self) -> None:
        """Search, and print what was found."""
        from tegotae.tuning import describe, judge, tune
        from tegotae.tuning.record import confirmation, ranking, tried_first

        if self.algorithm not in SPACES:
            raise unknown("algorithm", self.algorithm, SPACES)
        require_count("confirm", self.confirm, least=0)
        if self.keep is not None:
            output_file(self.keep)
        task, space = self.task, SPACES[self.algorithm]
        try:
            trials = tune(
                self.algorithm, task, self.storage, trials=self.trials, workers=self.workers
            )
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted; {self.storage} keeps what was tried, the same command goes on"
            ) from None
        document = describe(self.algorithm, task, space, trials)
        ranked = ranking(trials)
        _print(document, ranked)
        if self.confirm:
            fresh = dataclasses.replace(
                task, seeds=self.confirm, first_seed=FIRST_SEED + _FRESH_SEEDS
            )
            settings = [tried_first(space), space.suggest(ranked[0])]
            found = judge(space, settings, fresh, workers=self.workers)
            document["found"]["confirmation"] = confirmation(fresh, *found)
            _print_confirmation(document["found"]["confirmation"])
        if self.keep is not None:
            write_atomically(self.keep, json.dumps(document, indent=1) + "\n")
            print(f"wrote {self.keep}")

    @property
    def task(self) -> Task:
        """What settings are judged on."""
        # An agent's reward has no ΔΩ, and so it is judged without.
        follow_omega = not self.cot_only and self.algorithm not in agents()
        timing = Timing(duration_s=self.duration, tick_s=self.tick)
        fitness = Fitness(settle_s=self.settle, work=self.energy, follow_omega=follow_omega)
        experiments = tuple(
            find(name).experiment(budget=self.budget, timing=timing, fitness=fitness)
            for name in self.models
        )
        return Task(experiments=experiments, seeds=self.seeds, budget_s=self.budget_s)


def _print(document: dict[str, Any], ranked: list[FrozenTrial]) -> None:
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


def _print_confirmation(found: dict[str, Any]) -> None:
    def show(i: dict[str, float]) -> str:
        return f"{i['mean']:.4f} [{i['low']:.4f}, {i['high']:.4f}]"

    print(
        f"on {found['seeds']} fresh seeds per model: {show(found['best'])}, with the settings "
        f"tried first {show(found['tried_first'])}, difference {show(found['difference'])}"
    )
