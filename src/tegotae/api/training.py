"""Training of controllers of one model, on the engine or in another simulator."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError, require_all, require_count
from tegotae._support.limits import MOST_SEEDS
from tegotae.api import experiments
from tegotae.api.controller import Changes, Work
from tegotae.api.parameters import HIDDEN, Values, changes, filled, with_options, with_own_values
from tegotae.api.trained import TrainedControllers, advice, without_hops
from tegotae.api.wiring import DEFAULT_ENVIRONMENT, EnvironmentOptions, environment_of
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body
from tegotae.systems.env_documents import extras_of, stem_of
from tegotae.systems.experiment import Experiment, Trainable
from tegotae.systems.registry import is_reference, name_of
from tegotae.systems.resolve import experiment_of, law_on_robot, resolve
from tegotae.training.agents import AgentSettings
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.algorithms import Algorithm
from tegotae.training.curves import longest_s
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.learner import Learner
from tegotae.training.run import Run, train as train_run
from tegotae.training.settings import settings_named
from tegotae.training.tensorboard import tensorboard_log

_STOPPING = Stopping()
_EPISODES = 1000


@dataclass(frozen=True)
class Trainee:
    """Experiment, and the settings of its learning algorithm."""

    experiment: Trainable
    settings: Algorithm | AgentSettings | Learner
    environment: EnvironmentOptions
    place: str = ""
    """Part of the folder's name for another simulator."""

    @property
    def folder(self) -> Path:
        """Default folder of the training."""
        algorithm = name_of(type(self.settings))
        parts = (self.place, self.experiment.name, "" if algorithm == "pgpe" else algorithm)
        return Path("runs") / "-".join(filter(None, parts))

    def defaults(self) -> Values:
        """Return the values of the options of `train`."""
        option_defaults, _ = _options_of(self.experiment)
        hidden = () if isinstance(self.settings, Algorithm) else _OF_POPULATIONS
        hidden += () if isinstance(self.settings, AgentSettings) else _OF_AGENTS
        hidden += ("environment",) if isinstance(self.experiment, Experiment) else ()
        return {
            **option_defaults(self.experiment),
            "out": self.folder,
            "algorithm": self.settings,
            "generations": _STOPPING.generations,
            "plateau_share": _STOPPING.share,
            "plateau_tolerance": _STOPPING.tolerance,
            **dict.fromkeys(hidden, HIDDEN),
        }

    def learner(self, options: Any, experiment: Trainable) -> Learner:
        """Return the learner.

        Args:
            options: options of `train`, with the algorithm's settings.
            experiment: the experiment, with other values.
        """
        if isinstance(self.settings, Learner):
            return options.algorithm
        if isinstance(self.settings, AgentSettings):
            return _agent(options, experiment)
        return _population(options, experiment, self.environment.workers)


_OF_POPULATIONS = ("generations", "to_cap", "plateau_share", "plateau_tolerance", "start")
_OF_AGENTS = ("episodes", "as_long_as")


def _options_of(experiment: Trainable) -> tuple[Callable[..., Values], Callable[..., Any]]:
    """Return the defaults of the options of an experiment, and the function that applies them."""
    if isinstance(experiment, Experiment):
        return experiments.option_defaults, experiments.adjusted
    from tegotae.api import environment

    return environment.environment_defaults, environment.adjusted_on_environment


def _trainee(
    model: Any,
    *,
    env: str | None = None,
    environment: EnvironmentOptions | Changes = DEFAULT_ENVIRONMENT,
    algorithm: str | Algorithm | AgentSettings | Learner | Changes = "pgpe",
    tensorboard: bool = False,
    budget: int | None = None,
    oscillator: str | None = None,
    body: Any = None,
    fitness: Any = None,
    **_: Any,
) -> Trainee:
    """Return the experiment of a name, and its algorithm.

    Raises:
        TegotaeError: for a name that means nothing here, or values that do not fit together.
    """
    robot = law_on_robot(model) if isinstance(model, str) else None
    if robot is not None:
        model, env = robot
    options_of_environment, settings = environment_of(environment), _settings(algorithm)
    extras = {} if env is None else extras_of(env)
    if isinstance(settings, AgentSettings):
        extras["stable_baselines3"] = "sb3"
    if tensorboard:
        extras["tensorboardX"] = "tensorboard"
    require_all(extras)
    if env is None:
        for name in changes(options_of_environment, DEFAULT_ENVIRONMENT):
            raise TegotaeError(f"{name} belongs to environments; give env, too")
        experiment = experiments.with_parts(
            experiment_of(model, budget),
            budget=budget,
            oscillator=oscillator,
            body=body,
            fitness=fitness,
        )
        return Trainee(experiment, settings, options_of_environment)
    fitness = fitness.get("name") if isinstance(fitness, Mapping) else fitness
    for name, value in (("oscillator", oscillator), ("body", body)):
        if value is not None:
            raise TegotaeError(f"{name} belongs to this package's engine; leave env out")
    candidates = {"budget": budget, "fitness": fitness if isinstance(fitness, str) else None}
    overrides = {name: x for name, x in candidates.items() if x is not None}
    wired = options_of_environment.experiment(env, model, duration_s=24.0, **overrides)
    if fitness is not None and not isinstance(fitness, str):
        wired = replace(wired, objective=fitness)
    if robot is None:
        return Trainee(wired, settings, options_of_environment, place=stem_of(env))
    law = wired.name.partition("@")[0]  # without the walker that it is from
    name = re.sub(r"[^\w.+@-]+", "-", f"{law}@{stem_of(env)}", flags=re.ASCII)
    return Trainee(replace(wired, name=name), settings, options_of_environment)


def _settings(
    algorithm: str | Algorithm | AgentSettings | Learner | Changes,
) -> Algorithm | AgentSettings | Learner:
    """Return the settings of an algorithm, by name or changed."""
    if isinstance(algorithm, Mapping):
        return with_options(_settings(algorithm.get("name", "pgpe")), algorithm)
    if isinstance(algorithm, str):
        name = algorithm if is_reference(algorithm) else algorithm.lower()
        return settings_named(name, (Algorithm, AgentSettings, Learner))
    return algorithm


def _population(options: Any, experiment: Trainable, workers: int | None) -> Evolution:
    """Return the evolution of a population."""
    share, tolerance = options.plateau_share, options.plateau_tolerance
    if options.to_cap and (share, tolerance) != (_STOPPING.share, _STOPPING.tolerance):
        raise TegotaeError("to_cap sees no plateau; leave plateau_share and plateau_tolerance out")
    stopping = replace(_STOPPING, generations=options.generations, share=share, tolerance=tolerance)
    if options.to_cap:
        stopping = Stopping.after(options.generations)
    return Evolution(
        algorithm=options.algorithm,
        stopping=stopping,
        workers=workers,
        weights=() if options.start is None else _weights(options.start, experiment),
    )


def _weights(name: str, experiment: Trainable) -> tuple[float, ...]:
    """Return the weights of a controller by name, which must have the same terms."""
    saved = resolve(name).controller()
    if saved.controller != experiment.controller:
        raise TegotaeError(
            f"{name} has other terms than {experiment.name}; start from a controller of the "
            "same model"
        )
    return tuple(map(float, np.ravel(saved.weights)))


def _agent(options: Any, experiment: Trainable) -> AgentLearner:
    """Return the learner of an agent."""
    episodes = _EPISODES if options.episodes is None else options.episodes
    if options.as_long_as is not None:
        if options.episodes is not None:
            raise TegotaeError("episodes and as_long_as both say how long; leave one out")
        episodes = round(longest_s(Path(options.as_long_as)) / experiment.duration_s)
        if episodes < 1:
            raise TegotaeError(f"nothing has been learned in {options.as_long_as} yet")
    on_engine = isinstance(experiment, Experiment)
    every = AgentLearner.evaluate_every if on_engine else 40
    return AgentLearner(settings=options.algorithm, episodes=episodes, evaluate_every=every)


@wraps(_trainee)
def _option_defaults(model: Any, **options: Any) -> Values:
    return _trainee(model, **options).defaults()


@with_own_values(_option_defaults)
def train(
    model: str | Experiment,
    *,
    out: Path | str | None = None,
    seeds: int = 3,
    first_seed: int = 0,
    restart: bool = False,
    generations: int | None = None,
    to_cap: bool = False,
    plateau_share: float | None = None,
    plateau_tolerance: float | None = None,
    start: str | None = None,
    episodes: int | None = None,
    as_long_as: Path | str | None = None,
    drop_m: float | None = None,
    work: Work | None = None,
    sector_start_rad: float | None = None,
    sector_duration_s: float | None = None,
    newtons_per_feedback: float | None = None,
    tuned_over: Sequence[float] | None = None,
    algorithm: str | Algorithm | AgentSettings | Learner | Changes = "pgpe",
    env: str | None = None,
    environment: EnvironmentOptions | Changes = DEFAULT_ENVIRONMENT,
    tensorboard: bool = False,
    height_m: float | None = None,
    duration_s: float | None = None,
    tick_s: float | None = None,
    hold: bool | None = None,
    cot_only: bool = False,
    vary: Sequence[str] = (),
    episodes_per_candidate: int | None = None,
    budget: int | None = None,
    oscillator: str | None = None,
    body: str | Body | Changes | None = None,
    fitness: str | Objective | Changes | None = None,
) -> TrainedControllers:
    """Train controllers of a model, one per seed; run it again on the same folder to continue.

    Args:
        model: a recipe (see `tegotae models`), such as ART, or on legs ART@quadruped-c; or an
            experiment of your own, FILE.py:OBJECT or MODULE:OBJECT.
        out: folder for controllers, curves and checkpoint; by default runs/MODEL, or
            runs/MODEL-ALGORITHM.
        seeds: number of runs from random weights.
        first_seed: first seed; the others follow it.
        restart: start again, and move an existing training to a folder beside this one.
        generations: maximum number of generations of a population.
        to_cap: train for all generations; do not stop at the plateau.
        plateau_share: share of a run, at its end, in which the fitness must improve; otherwise the
            run has reached its plateau and ends.
        plateau_tolerance: smallest improvement that counts there [m/J].
        start: a controller of the same model, by file or name, whose weights each run begins with,
            in place of random ones.
        episodes: episodes per seed of an agent; 1000 by default.
        as_long_as: folder of another training: the agent gets the simulated time of its longest
            run.
        drop_m: height by which the ground drops in the evaluation [m].
        work: definition of the actuator's work.
        sector_start_rad: phase at which a vanilla sector starts [rad].
        sector_duration_s: duration of a vanilla sector at ω [s]; replaces its width in phase.
        newtons_per_feedback: force of a vanilla reflex per unit of feedback [N s/rad].
        tuned_over: offsets from ω_t at which the gain of a pure V is searched for [rad/s], such as
            -2 -1 0 1 2 for all frequencies of the evaluation.
        algorithm: learning algorithm: pgpe, cma-es, openai-es or snes (populations), sac or ppo
            (agents), or your own, FILE.py:OBJECT or MODULE:OBJECT; or its name with other settings,
            {"name": "cma-es", "std": 0.08}.
        env: environment in place of this package's engine: a Gymnasium id such as Hopper-v5;
            FILE.py:FUNCTION or MODULE:FUNCTION that makes one; a MuJoCo model, FILE.xml or, in an
            installed package, PACKAGE:FILE.xml; or hopper, leg or quadruped, which come with
            tegotae. A robot's file needs no option: MODEL@FILE.toml.
        environment: wiring of the limbs, and settings of the environment.
        tensorboard: write TensorBoard logs beside the controllers (extra "tensorboard").
        height_m: height of the release [m], in training and evaluation.
        duration_s: duration of a training episode [s].
        tick_s: control period in training [s].
        hold: hold the controller over each tick of the training, as a robot does.
        cot_only: use CoT⁻¹ alone as the fitness, without ΔΩ, as in the paper's comparison of
            algorithms. Agents always do.
        vary: conditions that vary between episodes of training, such as mass_kg=0.08:0.12 (any
            value between), omega=6/8/10 (one of these) or push_x_n=-5:5@8:8.2 (from 8 s to 8.2 s).
        episodes_per_candidate: number of episodes per candidate, if conditions vary.
        budget: maximum number of trained parameters of a model; the paper's by default.
        oscillator: another oscillator: hopf, adaptive-hopf, van-der-pol, matsuoka, or your own,
            FILE.py:OBJECT or MODULE:OBJECT. With the prefix learned- its parameters are trained,
            too.
        body: another body: your own, FILE.toml of `tegotae identify`, FILE.py:OBJECT or
            MODULE:OBJECT; or changes of the experiment's own.
        fitness: another fitness, FILE.py:OBJECT or MODULE:OBJECT. On an environment: hopping (CoT⁻¹
            + ΔΩ), return (the sum of its rewards), or a function of an episode, FILE.py:FUNCTION or
            MODULE:FUNCTION. Or changes of the experiment's own.

    Raises:
        TegotaeError: for a name that means nothing here, or values that do not fit together, before
            the training begins.

    Example:
        >>> train("ART", seeds=4, out="runs/art").plot()  # doctest: +SKIP
    """
    arguments = dict(locals())
    require_count("seeds", seeds, most=MOST_SEEDS)
    require_count("first_seed", first_seed, least=0, most=2**31 - 1 - seeds)
    trainee = _trainee(**arguments)
    parts = dict.fromkeys(x for x in ("body", "fitness") if not isinstance(arguments[x], Mapping))
    parts |= {"environment": None, "algorithm": trainee.settings}
    values = filled({**arguments, **parts}, trainee.defaults())
    _, adjusted = _options_of(trainee.experiment)
    experiment = adjusted(trainee.experiment, vars(values))
    learner = trainee.learner(values, experiment)
    runs = tuple(range(first_seed, first_seed + seeds))
    run, folder = Run(experiment=experiment, seeds=runs, learner=learner), Path(values.out)
    log = tensorboard_log(folder) if tensorboard else None
    try:
        files = train_run(run, folder, restart=restart, on_step=log)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; {folder} keeps what was learned, the same command continues from there"
        ) from None
    trained = TrainedControllers.from_files(experiment.name, folder, files, learner.UNIT)
    if isinstance(experiment, Experiment):
        return replace(trained, notes=[*trained.notes, *without_hops(trained, experiment)])
    evolves = isinstance(trainee.settings, Algorithm)
    tolerance = values.plateau_tolerance if evolves else _STOPPING.tolerance
    return replace(trained, notes=[*trained.notes, *advice(trained, tolerance=tolerance)])
