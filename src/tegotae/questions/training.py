"""Training: controllers of one model are learned, on the engine or in another simulator."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require, require_all, require_count
from tegotae._support.limits import MOST_SEEDS
from tegotae.measures.hopping.statistics import interval
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.questions.answer import Answer, AnswerBase
from tegotae.questions.experiments import ExperimentOptions, Experiments
from tegotae.questions.options import without_unit
from tegotae.questions.question import question
from tegotae.questions.verbs import evaluate, simulate
from tegotae.questions.wiring import OnEnvironment, stem_of
from tegotae.systems.controller_file import load
from tegotae.systems.env_task import extras_of
from tegotae.systems.experiment import Experiment
from tegotae.systems.registry import name_of
from tegotae.systems.resolve import resolve
from tegotae.systems.robot_file import law_on_robot
from tegotae.systems.user_objects import is_reference
from tegotae.training.agents import AgentSettings
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.algorithms import Algorithm
from tegotae.training.curves import FITNESS, longest_s, read_curves
from tegotae.training.evolution import CAP, PLATEAU, RUNNING, SEARCH, Evolution, Stopping
from tegotae.training.learner import Trainable, TrainingState
from tegotae.training.run import COLUMNS, Run, curves_of, train as train_run
from tegotae.training.settings import settings_named

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ENDED = {
    PLATEAU: "on its plateau",
    CAP: "at the cap: more generations may gain more",
    SEARCH: "found by search",
    RUNNING: "not yet",
}
"""Why a training ended, in words."""
_USUAL = Stopping()
_EPISODES = 1000


@dataclass(frozen=True)
class Trainee:
    """What is trained, and by which algorithm."""

    experiment: Trainable
    settings: Algorithm | AgentSettings
    workers: int | None = None
    tensorboard: bool = False
    place: str = ""
    """Of another simulator the part of the folder's name."""

    @property
    def name(self) -> str:
        """Of the experiment."""
        return self.experiment.name

    @property
    def folder(self) -> Path:
        """Where it is trained unless another folder is asked for."""
        algorithm = name_of(type(self.settings))
        parts = (self.place, self.name, "" if algorithm == "pgpe" else algorithm)
        return Path("runs") / "-".join(filter(None, parts))


@dataclass(frozen=True, kw_only=True)
class Trainees(OnEnvironment, Experiments):
    """Models by name, where they are trained, and by what."""

    env: str | None = None
    """The environment, in place of this package's engine: a Gymnasium id such as Hopper-v5;
    FILE.py:FUNCTION or MODULE:FUNCTION that makes one; a MuJoCo model, FILE.xml or, in an installed
    package, PACKAGE:FILE.xml; or hopper, leg or quadruped, which come with tegotae. A robot's file
    needs no option: MODEL@FILE.toml."""
    algorithm: str = "pgpe"
    """Learning algorithm: pgpe, cma-es or openai-es (populations), sac or ppo (agents), or your
    own, FILE.py:OBJECT or MODULE:OBJECT."""
    tensorboard: bool = False
    """Write TensorBoard logs beside the controllers (extra "tensorboard")."""

    def named(self, *names: Any) -> Sequence[Trainee]:
        """What is trained.

        Raises:
            TegotaeError: for a name that means nothing here, or what does not fit together.
        """
        if names and all(isinstance(name, Trainee) for name in names):
            return names
        if len(names) == 1 and (on_robot := law_on_robot(str(names[0]))) is not None:
            law, robot = on_robot
            return replace(self, env=robot).named(law)
        algorithm = self.algorithm if is_reference(self.algorithm) else self.algorithm.lower()
        settings = settings_named(algorithm, (Algorithm, AgentSettings))
        extras = {} if self.env is None else extras_of(self.env)
        if isinstance(settings, AgentSettings):
            extras["stable_baselines3"] = "sb3"
        if self.tensorboard:
            extras["tensorboardX"] = "tensorboard"
        require_all(extras)
        how = {"settings": settings, "workers": self.workers, "tensorboard": self.tensorboard}
        if self.env is None:
            self._refuse(OnEnvironment, "belongs to environments; give --env, too")
            return [Trainee(experiment, **how) for experiment in super().named(*names)]
        kept = {"budget": self.budget, "fitness": self.fitness}
        replace(self, **dict.fromkeys(kept))._refuse(
            Experiments, "belongs to this package's engine; leave --env out"
        )
        given = {name: x for name, x in kept.items() if x is not None}
        made = [self.experiment(self.env, name, duration_s=24.0, **given) for name in names]
        return [Trainee(experiment, **how, place=stem_of(self.env)) for experiment in made]

    def _refuse(self, owner: type, why: str) -> None:
        """Raise `TegotaeError` for an option of a class that is given."""
        for option in dataclasses.fields(owner):
            if getattr(self, option.name) != option.default:
                name = without_unit(option.name).replace("_", "-")
                raise TegotaeError(f"--{name} {why}")


@dataclass(frozen=True, kw_only=True)
class PopulationOptions:
    """How long a population evolves, and the settings of its algorithm."""

    generations: int = _USUAL.generations
    """Maximum number of generations."""
    to_cap: bool = False
    """Train for all generations; do not stop at the plateau."""
    plateau_share: float = _USUAL.share
    """Share of a run, at its end, in which the fitness must improve; otherwise the run has reached
    its plateau and ends."""
    plateau_tolerance: float = _USUAL.tolerance
    """Smallest improvement that counts there [m/J]."""
    start: str | None = None
    """A controller of the same model, by file or name, whose weights each run begins with, in place
    of random ones."""
    settings: Algorithm

    def learner(self, trainee: Trainee, experiment: Trainable) -> Evolution:
        """The learner."""
        rule = self.plateau_share, self.plateau_tolerance
        if self.to_cap and rule != (_USUAL.share, _USUAL.tolerance):
            raise TegotaeError("--to-cap sees no plateau; leave --plateau-share and -tolerance out")
        stopping = replace(_USUAL, generations=self.generations, share=rule[0], tolerance=rule[1])
        if self.to_cap:
            stopping = Stopping.after(self.generations)
        return Evolution(
            algorithm=self.settings,
            stopping=stopping,
            workers=trainee.workers,
            weights=() if self.start is None else self._weights(self.start, experiment),
        )

    @staticmethod
    def _weights(name: str, experiment: Trainable) -> tuple[float, ...]:
        """Of a controller by name, which must be of the same terms."""
        saved = resolve(name).controller()
        if saved.controller != experiment.controller:
            raise TegotaeError(
                f"{name} has other terms than {experiment.name}; start from a controller of the "
                "same model"
            )
        return tuple(map(float, np.ravel(saved.weights)))


@dataclass(frozen=True, kw_only=True)
class AgentOptions:
    """How long an agent learns, and the settings of its algorithm."""

    episodes: int | None = None
    """Episodes per seed; 1000 by default."""
    as_long_as: Path | None = None
    """Folder of another training: the agent gets the simulated time of its longest run."""
    settings: AgentSettings

    def learner(self, trainee: Trainee, experiment: Trainable) -> AgentLearner:
        """The learner."""
        episodes = _EPISODES if self.episodes is None else self.episodes
        if self.as_long_as is not None:
            if self.episodes is not None:
                raise TegotaeError("--episodes and --as-long-as both say how long; leave one out")
            episodes = round(longest_s(self.as_long_as) / experiment.duration_s)
            if episodes < 1:
                raise TegotaeError(f"nothing has been learned in {self.as_long_as} yet")
        on_engine = isinstance(experiment, Experiment)
        every = AgentLearner.evaluate_every if on_engine else 40
        return AgentLearner(settings=self.settings, episodes=episodes, evaluate_every=every)


@dataclass(frozen=True, kw_only=True)
class TrainingOptions:
    """Where a training is kept, from which seeds, of what and how long."""

    out: Path | None = None
    """Folder for controllers, curves and checkpoint; by default runs/MODEL, or
    runs/MODEL-ALGORITHM."""
    seeds: int = 3
    """Number of runs from random weights."""
    first_seed: int = 0
    """First seed; the others follow it."""
    anew: bool = False
    """Start again, and move an existing training to a folder beside this one."""
    experiment: Any
    learner: PopulationOptions | AgentOptions

    def __post_init__(self) -> None:
        require_count("seeds", self.seeds, most=MOST_SEEDS)
        require_count("first_seed", self.first_seed, least=0, most=2**31 - 1 - self.seeds)

    @classmethod
    def options_of(cls, trainee: Trainee) -> TrainingOptions:
        """The options of an experiment and an algorithm, with their own values."""
        experiment, settings = trainee.experiment, trainee.settings
        learns = AgentOptions if isinstance(settings, AgentSettings) else PopulationOptions
        learner: Any = learns(settings=settings)  # type: ignore[arg-type]
        if isinstance(experiment, Experiment):
            return cls(experiment=ExperimentOptions.options_of(experiment), learner=learner)
        from tegotae.questions.environment import EnvironmentTraining

        own = EnvironmentTraining.options_of(experiment)  # type: ignore[arg-type]
        return cls(experiment=own, learner=learner)


@dataclass(frozen=True, repr=False)
class TrainedControllers(AnswerBase):
    """What a training came to: controllers and learning curves in a folder."""

    name: str
    """Of the experiment."""
    folder: Path
    files: tuple[Path, ...]
    """Of the controllers, one a run."""
    unit: str
    """What is counted: generations or episodes."""
    remarks: tuple[str, ...] = ()

    @cached_property
    def runs(self) -> list[Mapping[str, Any]]:
        """What each run came to, as its controller file says."""
        return [load(path).training for path in self.files]

    def evaluate(self, **options: Any) -> Answer:
        """Evaluate the controllers.

        Args:
            options: of `tegotae.evaluate`.
        """
        return evaluate(self.folder, **options)

    def frame(self) -> pd.DataFrame:
        """The learning curves, a row a point; of a search none."""
        curves = self.folder / "curves.csv"
        return curves_of(curves) if curves.exists() else pd.DataFrame(columns=COLUMNS)

    def texts(self) -> list[pd.DataFrame]:
        unit = self.unit
        rows = [
            {
                "controller": str(path),
                "fitness": f"{run['best_fitness']:.4f}",
                f"best {unit}": f"{run[f'best_{unit}']:g}",
                f"{unit}s": f"{run[f'{unit}s']:g}",
                **({"ended": _ENDED[run["ended"]]} if "ended" in run else {}),
            }
            for path, run in zip(self.files, self.runs, strict=True)
        ]
        return [pd.DataFrame(rows).set_index("controller")]

    @property
    def notes(self) -> list[str]:
        fitness = [float(run["best_fitness"]) for run in self.runs]
        notes = []
        if len(fitness) > 1:
            best = interval(fitness)
            notes.append(
                f"fitness {best.mean:.4f}, 95 % interval of the mean over {len(fitness)} runs "
                f"[{best.low:.4f}, {best.high:.4f}]"
            )
        if lost := sum(x < 0.5 * FAILED_FITNESS for x in fitness):
            notes.append(
                f"{lost} of {len(fitness)} learned nothing: no candidate survived its episode, "
                "so the fitness has no other meaning."
            )
        unit = self.unit
        if stuck := sum(run[f"best_{unit}"] == 0 and run[f"{unit}s"] > 20 for run in self.runs):
            cure = "Try a smaller --learning-rate, a smaller --noise, and more --episodes."
            if unit != AgentLearner.UNIT:
                cure = "A law of a few numbers learns with --algorithm cma-es --std 0.08."
            notes.append(
                f"{stuck} of {len(fitness)} never got better than they began; their steps may be "
                f"too large. {cure}"
            )
        return [*notes, *self.remarks]

    def document(self) -> JsonObject:
        """What each run came to, and where it is."""
        runs = [
            {"controller": str(path), **run}
            for path, run in zip(self.files, self.runs, strict=True)
        ]
        return as_json({"name": self.name, "folder": str(self.folder), "runs": runs})

    def figures(self) -> dict[str, Figure]:
        from tegotae.figures.learning_curves import algorithms_figure

        if self.frame().empty:
            return {}
        return {"curves": algorithms_figure(read_curves([self.folder], None))}

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Write picture and numbers into another folder; its own has all that was learned."""
        return [] if Path(folder) == self.folder else super().save(folder, format)


@question(
    subjects=Trainees,
    kinds={
        "One leg, such as ART": "ART",
        "Several legs, such as AR@quadruped-c": "AR@quadruped-c",
        "In another simulator (--env)": lambda: _in_another_simulator(),
        "An agent (--algorithm sac)": lambda: AgentOptions(settings=settings_named("sac")),
    },
)
def train(trainee: Trainee, options: TrainingOptions) -> TrainedControllers:
    """Train controllers of a model, one per seed; run it again on the same folder to continue.

    Example:
        >>> train("ART", seeds=4, out="runs/art").plot()  # doctest: +SKIP
    """
    experiment = options.experiment.applied(trainee.experiment)
    learner = options.learner.learner(trainee, experiment)
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    run = Run(experiment=experiment, seeds=tuple(seeds), learner=learner)
    out = trainee.folder if options.out is None else Path(options.out)
    log = tensorboard_log(out) if trainee.tensorboard else None
    try:
        files = train_run(run, out, anew=options.anew, on_step=log)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; {out} keeps what was learned, the same command continues from there"
        ) from None
    answer = TrainedControllers(experiment.name, out, tuple(files), learner.UNIT)
    if isinstance(experiment, Experiment):
        return replace(answer, remarks=tuple(without_hops(answer, experiment)))
    least = _USUAL.tolerance
    if isinstance(options.learner, PopulationOptions):
        least = options.learner.plateau_tolerance
    return replace(answer, remarks=tuple(advice(answer, least=least)))


def without_hops(answer: TrainedControllers, experiment: Experiment) -> list[str]:
    """Return a line on runs whose result does not hop, and what to try.

    Args:
        answer: controllers and learning curves.
        experiment: what was trained; only of a body with one leg it is said.
    """
    curves = answer.frame()
    if experiment.body.limbs > 1:
        return []
    if curves.empty:  # a search, of whose result there is no curve
        resting = sum("no hop" in " ".join(simulate(path).remarks) for path in answer.files)
    else:
        last = curves.groupby("seed")["cot_inverse"].last()
        resting = sum(not cot > 0.0 for cot in last.iloc[-len(answer.files) :])
    if not resting:
        return []
    body = experiment.body
    weight_n, force_n = getattr(body, "weight_n", math.nan), float(body.max_force_n)
    return [
        f"{resting} of {len(answer.files)} do not hop: CoT⁻¹ is 0 where they end. The body weighs "
        f"{weight_n:.3g} N and pushes with {force_n:.3g} N, and is released at "
        f"{experiment.system.release.height_m:.3g} m over a leg of {body.rest_length_m:.3g} m. Try "
        "in this order: a name with ω near √(k/m), such as -w14; ART, which learns the push; a "
        f"higher --height; more {answer.unit}s and --seeds."
    ]


def _in_another_simulator() -> Any:
    """The options of a training there, which is an extra."""
    from tegotae.questions.environment import EnvironmentTraining
    from tegotae.training.environments.objectives import Hopping

    return EnvironmentTraining(duration_s=24.0, episodes_per_candidate=1, objective=Hopping())


def tensorboard_log(out: Path) -> Callable[[TrainingState], None]:
    """A function that logs the points of a step for TensorBoard, into a folder made by then.

    Raises:
        TegotaeError: at once, if tensorboardX is not installed.
    """
    tensorboard = require("tensorboardX", "tensorboard")

    @cache
    def writer() -> Any:
        return tensorboard.SummaryWriter(str(out / "tensorboard"))

    def log(step: TrainingState) -> None:
        for point in step.new:
            for name, value in point._asdict().items():
                if name not in ("seed", "step") and not math.isnan(value):
                    writer().add_scalar(f"{name}/seed{point.seed}", value, round(point.step))
        writer().flush()

    return log


def advice(answer: TrainedControllers, *, least: float) -> list[str]:
    """Why a body on an environment never leaves the ground, and what to try where no run gained
    more than `least`."""
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.environments.replay import replay

    said = []
    best = max(map(load, answer.files), key=lambda run: float(run.training["best_fitness"]))  # type: ignore[arg-type]
    experiment = EnvExperiment.of(best)
    if experiment.spec.is_model and (why := replay(experiment, [best.weights])[0].why_on_ground()):
        said.append(f"The best run {why}.")
    if answer.frame().empty:  # a search, in which nothing is learned
        return said
    runs = read_curves([answer.folder], FITNESS).groupby("seed")[FITNESS]
    gain = max(float(run.max() - run.iloc[0]) for _, run in runs)
    if gain <= least:
        more = "a larger --population; more --generations."
        said.append(
            f"Nothing was learned: no run gained more than {gain:.3g}. Try in this order: "
            "tegotae wiring baseline, which shows whether feedback matters there at all; larger "
            "pushes in the wiring; another --omega; "
            + ("more --episodes." if answer.unit == AgentLearner.UNIT else more)
        )
    return said
