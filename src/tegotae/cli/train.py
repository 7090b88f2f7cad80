"""`tegotae train`: learn controllers of one model, on the engine or on an environment."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import numpy as np
import tyro

from tegotae._support.errors import TegotaeError, require, require_all, require_count
from tegotae._support.limits import MOST_SEEDS
from tegotae.cli.console import print_rows
from tegotae.cli.env_options import EnvOptions
from tegotae.cli.options import ExperimentOptions, experiment_named
from tegotae.measures.hopping.statistics import interval
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.systems.env_task import extras_of
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.registry import name_of
from tegotae.systems.user_objects import is_reference
from tegotae.training.agents import AgentLearner, AgentSettings
from tegotae.training.algorithms import Algorithm
from tegotae.training.evolution import CAP, PLATEAU, RUNNING, SEARCH, Evolution, Stopping
from tegotae.training.learner import Trainable, TrainingState
from tegotae.training.run import Run, train
from tegotae.training.settings import agents, evolutions, settings_named

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment

_ON_ENVIRONMENTS = {"duration", "settle", "work", "cot_only", "fitness", "episodes_per_candidate"}
"""Options of an experiment that one on an environment has, too."""

_USUAL = Stopping()
_CAP_HINT = f"(default: {_USUAL.generations})"
_SHARE_HINT = f"(default: {_USUAL.share:g})"
_BUDGET_HINT = f"(default: {BUDGET})"
_GAIN_HINT = f"(default: {_USUAL.tolerance:g})"


@dataclass(frozen=True, kw_only=True)
class EvolutionOptions:
    """Where a training is kept, from which seeds, and how long a population evolves."""

    out: Annotated[
        Path | None,
        tyro.conf.arg(help_behavior_hint="(default: runs/MODEL, or runs/MODEL-ALGORITHM)"),
    ] = None
    """Folder for controllers, curves and checkpoint."""
    seeds: int = 3
    """Number of runs from random weights."""
    first_seed: int = 0
    """First seed; the others follow it."""
    population: Annotated[int | None, tyro.conf.arg(help_behavior_hint="(as tuned)")] = None
    """Candidates per generation and seed, of a population."""
    generations: Annotated[int | None, tyro.conf.arg(help_behavior_hint=_CAP_HINT)] = None
    """Maximum number of generations, of a population."""
    to_cap: bool = False
    """Train for all generations; do not stop at the plateau."""
    plateau_share: Annotated[float | None, tyro.conf.arg(help_behavior_hint=_SHARE_HINT)] = None
    """Share of a run, at its end, in which the fitness must improve; otherwise the run has reached
    its plateau and ends."""
    plateau_tolerance: Annotated[float | None, tyro.conf.arg(help_behavior_hint=_GAIN_HINT)] = None
    """Smallest improvement that counts there [m/J]."""
    algorithm: str = "pgpe"
    """Learning algorithm: pgpe, cma-es or openai-es (populations), sac or ppo (agents), or your
    own, FILE.py:OBJECT or MODULE:OBJECT."""
    budget: Annotated[int | None, tyro.conf.arg(help_behavior_hint=_BUDGET_HINT)] = None
    """Maximum number of trained parameters of a model."""
    anew: bool = False
    """Start again, and move an existing training to a folder beside this one."""
    tensorboard: bool = False
    """Write TensorBoard logs beside the controllers (extra "tensorboard")."""

    @property
    def stopping(self) -> Stopping:
        """When a run of an evolution ends."""
        given = {
            "generations": self.generations,
            "share": self.plateau_share,
            "tolerance": self.plateau_tolerance,
        }
        if self.to_cap and (given["share"] or given["tolerance"]) is not None:
            raise TegotaeError("--to-cap sees no plateau; leave --plateau-share and -tolerance out")
        chosen = replace(_USUAL, **{name: x for name, x in given.items() if x is not None})
        return Stopping.after(chosen.generations) if self.to_cap else chosen

    @property
    def seed_numbers(self) -> tuple[int, ...]:
        """The seeds."""
        require_count("seeds", self.seeds, most=MOST_SEEDS)
        require_count("first_seed", self.first_seed, least=0, most=2**31 - 1 - self.seeds)
        return tuple(range(self.first_seed, self.first_seed + self.seeds))


@dataclass(frozen=True, kw_only=True)
class Train(EnvOptions, EvolutionOptions, ExperimentOptions):
    """Train controllers of a model, one per seed; run it again on the same folder to continue."""

    model: Annotated[str, tyro.conf.Positional]
    """A model (see `tegotae models`), an architecture such as ART, a design for a body with legs
    such as ART@quadruped-c, or an experiment of your own, FILE.py:OBJECT or MODULE:OBJECT."""
    episodes: Annotated[int | None, tyro.conf.arg(help_behavior_hint="(default: 1000)")] = None
    """Episodes per seed, of an agent (sac, ppo)."""
    as_long_as: Annotated[
        Path | None, tyro.conf.arg(help_behavior_hint="(default: --episodes)")
    ] = None
    """Folder of another training: an agent gets the simulated time of its longest run."""

    def run(self) -> None:
        """Train, and print the outcome."""
        on_engine = self.env is None
        settings = settings_named(self._algorithm_name, (Algorithm, AgentSettings))
        self._require_extras(isinstance(settings, AgentSettings))
        _ = self.seed_numbers
        experiment = self._on_engine() if on_engine else self._on_environment()
        algorithm = name_of(type(settings))
        called = experiment.name if on_engine else f"{self.called}-{experiment.name}"
        folder = called if algorithm == "pgpe" else f"{called}-{algorithm}"
        out = Path("runs") / folder if self.out is None else self.out
        learns = isinstance(settings, AgentSettings)
        try:
            learn = self._agents if learns else self._evolution
            paths = learn(experiment, settings, out)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted; {out} keeps what was learned, the same command continues from there"
            ) from None
        summarise(paths, "episode" if learns else "generation")
        if not on_engine:
            advise(out, paths, least=self.stopping.tolerance, agent=learns)

    def _require_extras(self, learns: bool) -> None:
        needed = {} if self.env is None else extras_of(self.env)
        if learns:
            needed["stable_baselines3"] = "sb3"
        if self.tensorboard:
            needed["tensorboardX"] = "tensorboard"
        require_all(needed)

    @property
    def _algorithm_name(self) -> str:
        """The algorithm, of the package's in small letters."""
        return self.algorithm if is_reference(self.algorithm) else self.algorithm.lower()

    def _on_engine(self) -> Experiment:
        self.require_engine()
        return self.applied(experiment_named(self.model, self.budget), self.budget)

    def _on_environment(self) -> EnvExperiment:
        for field in dataclasses.fields(ExperimentOptions):
            if field.name not in _ON_ENVIRONMENTS and getattr(self, field.name) != field.default:
                option = field.name.replace("_", "-")
                raise TegotaeError(f"--{option} belongs to this package's engine; leave --env out")
        if self.episodes is not None and self._algorithm_name in evolutions():
            raise TegotaeError(
                "--episodes counts those of an agent (sac, ppo); a candidate of a population has "
                "--episodes-per-candidate"
            )
        own = {"episodes": self.episodes_per_candidate, "budget": self.budget}
        hopping = {"settle_s": self.settle, "work": self.work}
        if self.cot_only:
            hopping["follow_omega"] = False
        return self.experiment_of(
            self.model,
            duration_s=24.0 if self.duration is None else self.duration,
            fitness=self.fitness,
            hopping={name: value for name, value in hopping.items() if value is not None},
            **{name: value for name, value in own.items() if value is not None},
        )

    def _evolution(self, experiment: Trainable, settings: Algorithm, out: Path) -> list[Path]:
        self._refuse("episodes", agents())
        self._refuse("as_long_as", agents())
        chosen = {} if self.population is None else {"population": self.population}
        run = Run(
            experiment=experiment,
            seeds=self.seed_numbers,
            learner=Evolution(
                algorithm=replace(settings, **chosen),
                stopping=self.stopping,
                workers=self.workers,
            ),
        )
        log = logger(out) if self.tensorboard else None
        return train(run, out, anew=self.anew, on_step=log)

    def _agents(self, experiment: Trainable, settings: AgentSettings, out: Path) -> list[Path]:
        self._refuse("population", evolutions())
        for option in ("generations", "to_cap", "plateau_share", "plateau_tolerance"):
            self._refuse(option, evolutions())
        learner = AgentLearner(
            settings=settings,
            episodes=self._agents_episodes(experiment),
            evaluate_every=AgentLearner.evaluate_every if experiment.task is None else 40,
        )
        run = Run(experiment=experiment, seeds=self.seed_numbers, learner=learner)
        log = logger(out) if self.tensorboard else None
        return train(run, out, anew=self.anew, on_step=log)

    def _agents_episodes(self, experiment: Trainable) -> int:
        """How many episodes an agent learns from."""
        if self.as_long_as is None:
            return 1000 if self.episodes is None else self.episodes
        if self.episodes is not None:
            raise TegotaeError("--episodes and --as-long-as both say how long; leave one out")
        episodes = round(longest_s(self.as_long_as) / experiment.duration_s)
        if episodes < 1:
            raise TegotaeError(f"nothing has been learned in {self.as_long_as} yet")
        return episodes

    def _refuse(self, option: str, owners: Iterable[str]) -> None:
        if getattr(self, option) not in (None, False):
            raise TegotaeError(
                f"--{option.replace('_', '-')} belongs to {', '.join(sorted(owners))}; "
                f"{self.algorithm} has no such option"
            )


def longest_s(folder: Path) -> float:
    """Simulated time from which the longest run of a training has learned [s].

    Raises:
        TegotaeError: for a folder without the learning curves of a training.
    """
    from tegotae.training.folder import curves_of

    if not (folder / "curves.csv").is_file():
        raise TegotaeError(f"{folder} holds no training to learn as long as; it has no curves.csv")
    columns = curves_of(folder / "curves.csv")
    times = np.unique(columns["simulated_s"])
    if len(times) < 2:
        return 0.0
    # A point of a population is at the beginning of its generation.
    of_population = bool(np.isfinite(columns["best_fitness"]).any())
    return float(times[-1] + of_population * (times[-1] - times[-2]))


def logger(out: Path) -> Callable[[TrainingState], None]:
    """A function that logs the points of a step for TensorBoard, into a folder made by then.

    Raises:
        TegotaeError: at once, if tensorboardX is not installed.
    """
    tensorboard = require("tensorboardX", "tensorboard")

    @cache
    def writer():
        return tensorboard.SummaryWriter(str(out / "tensorboard"))

    def log(step: TrainingState) -> None:
        for point in step.new:
            for name, value in point._asdict().items():
                if name not in ("seed", "step") and not math.isnan(value):
                    writer().add_scalar(f"{name}/seed{point.seed}", value, round(point.step))
        writer().flush()

    return log


_ENDED = {
    PLATEAU: "on its plateau",
    CAP: "at the cap: more generations may gain more",
    SEARCH: "found by search",
    RUNNING: "not yet",
}
"""Why a training ended, in words."""


def summarise(paths: list[Path], unit: str) -> None:
    """The end of each seed's training, counted in generations or episodes."""
    from tegotae.systems.controller_file import load

    found = [(path, load(path).training) for path in paths]
    evolved = all("ended" in training for _, training in found)
    print_rows(
        ("controller", "fitness", f"best {unit}", f"{unit}s", *(["ended"] if evolved else [])),
        (
            (
                str(path),
                f"{training['best_fitness']:.4f}",
                f"{training[f'best_{unit}']:g}",
                f"{training[f'{unit}s']:g}",
                *([_ENDED[cast(str, training["ended"])]] if evolved else []),
            )
            for path, training in found
        ),
    )
    if len(found) > 1:
        best = interval([float(cast(float, training["best_fitness"])) for _, training in found])
        print(
            f"fitness {best.mean:.4f}, 95 % interval of the mean over {len(found)} runs "
            f"[{best.low:.4f}, {best.high:.4f}]"
        )
    lost = sum(
        cast(float, training["best_fitness"]) < 0.5 * FAILED_FITNESS for _, training in found
    )
    if lost:
        print(
            f"{lost} of {len(found)} learned nothing: no candidate survived its episode, "
            "so the fitness has no other meaning."
        )


def advise(out: Path, paths: Sequence[Path], *, least: float, agent: bool = False) -> None:
    """Say of a training on an environment why its body never leaves the ground, and what to try
    where no run gained more than `least`."""
    from tegotae.systems.controller_file import load
    from tegotae.training.curves import FITNESS, read_curves
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.environments.replay import replay

    best = max(map(load, paths), key=lambda run: cast(float, run.training["best_fitness"]))
    experiment = EnvExperiment.of(best)
    if experiment.spec.is_model and (why := replay(experiment, [best.weights])[0].why_on_ground()):
        print(f"The best run {why}.")
    if not (out / "curves.csv").exists():  # a search, in which nothing is learned
        return
    gains = [float(c.value.max() - c.value[0]) for c in read_curves([out], FITNESS)]
    if max(gains) > least:
        return
    print(
        f"Nothing was learned: no run gained more than {max(gains):.3g}. Try in this order: "
        "tegotae wiring baseline, which shows whether feedback matters there at all; larger pushes "
        "in the wiring; another --omega; "
        + ("more --episodes." if agent else "a larger --population; more --generations.")
    )
