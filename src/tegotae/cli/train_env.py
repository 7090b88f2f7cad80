"""`tegotae train-env`: learn controllers of limbs in anyone's simulator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import tyro

from tegotae._support.documents import DamagedDocumentError, parse
from tegotae._support.errors import TegotaeError
from tegotae._support.optional_dependencies import require
from tegotae.cli.options import settings_named
from tegotae.cli.train import EvolutionOptions, logger, summarise
from tegotae.systems.models import find
from tegotae.systems.registry import name_of
from tegotae.systems.user_objects import is_reference
from tegotae.training.algorithms import Algorithm
from tegotae.training.run import Run, train

_ITS_OWN = tyro.conf.arg(help_behavior_hint="(default: the model's own)")
_OWN = tyro.conf.arg(help_behavior_hint="(default: the environment's)")
_WIRINGS_OMEGA = tyro.conf.arg(help_behavior_hint="(default: the wiring's, or else the model's)")
_BY_WHAT = tyro.conf.arg(help_behavior_hint="(default: hopping, where it can be measured)")


@dataclass(frozen=True, kw_only=True)
class TrainEnv(EvolutionOptions):
    """Train limbs on a Gymnasium environment or a MuJoCo model; run it again to go on."""

    env: Annotated[str, tyro.conf.Positional]
    """A Gymnasium id such as Hopper-v5; FILE.py:FUNCTION or MODULE:FUNCTION that makes an
    environment; a MuJoCo model FILE.xml, or PACKAGE:FILE.xml of an installed package; or one of
    this package: hopper, leg, quadruped."""
    wiring: Annotated[
        str | None, tyro.conf.arg(help_behavior_hint="(default: the model's own)")
    ] = None
    """What limbs sense and drive: a .toml or .json file."""
    model: str = "ART"
    """The controller: a model's name (see `tegotae models`), or an architecture such as ART."""
    omega: Annotated[float | None, _WIRINGS_OMEGA] = None
    """Frequency of the oscillators [rad/s]."""
    fitness: Annotated[str | None, _BY_WHAT] = None
    """By what an episode is judged: hopping (CoT⁻¹ + ΔΩ), return (the environment's rewards), or
    FILE.py:FUNCTION or MODULE:FUNCTION, of an episode."""
    duration: float = 24.0
    """Length of an episode, if the environment does not end it before [s]."""
    settle: Annotated[float | None, tyro.conf.arg(help_behavior_hint="(default: half)")] = None
    """Time in an episode before hopping is judged [s]."""
    episodes: int = 1
    """Episodes that each candidate is judged by; on MuJoCo models several take noise."""
    feet: tuple[str, ...] = ()
    """Of a MuJoCo model FILE.xml, the bodies whose contact forces are observed."""
    control: Annotated[float | None, _OWN] = None
    """Of a MuJoCo model, the time for which an action is held [s]."""
    settings: tuple[str, ...] = ()
    """What else the environment is made with: NAME=VALUE, values as in JSON."""
    scales: bool = False
    """Take scales that the wiring lacks from the MuJoCo model's weight and length."""
    workers: Annotated[int | None, tyro.conf.arg(help_behavior_hint="(default: one a core)")] = None
    """Worker processes that step environments; 0 for none. MuJoCo models need none."""
    limit: float = 60.0
    """Longest time that one step of an environment may take [s]; it has hung then."""

    def run(self) -> None:
        """Train, and print how it went."""
        settings = settings_named(self.algorithm, (Algorithm,))
        experiment = self._experiment()
        chosen = {} if self.population is None else {"population": self.population}
        run = Run(
            experiment=experiment,
            seeds=self.seed_numbers,
            stopping=self.stopping,
            algorithm=replace(settings, **chosen),
            workers=self.workers,
        )
        algorithm = name_of(type(settings))
        function = not experiment.spec.is_model and self.env.rpartition(":")[0]
        own = Path(function or self.env).stem
        folder = f"{own}-{experiment.name}" + ("" if algorithm == "pgpe" else f"-{algorithm}")
        out = Path("runs") / folder if self.out is None else self.out
        try:
            log = logger(out) if self.tensorboard else None
            paths = train(run, out, anew=self.anew, on_generation=log)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted; {out} keeps what was learned, the same command goes on from there"
            ) from None
        summarise(paths, "generation")

    def _experiment(self) -> Any:
        """What is trained.

        Raises:
            MissingExtraError: without Gymnasium, or MuJoCo where it is needed.
        """
        require("gymnasium", "gym")
        from tegotae.envs.env_spec import EnvSpec
        from tegotae.envs.wiring_file import load_wiring, packaged
        from tegotae.training.environments.experiment import EnvExperiment
        from tegotae.training.environments.objectives import Hopping, env_objective_named

        if is_reference(self.model):
            raise TegotaeError(
                f"{self.model} cannot be trained on an environment; name a model, such as ART"
            )
        spec = EnvSpec(env=self.env, settings=self._made_with())
        if self.wiring is None and self.env not in packaged():
            spec.make().close()  # a name with a slip lacks more than a wiring
            raise TegotaeError(
                f"no wiring is given for {self.env}; write --wiring FILE.toml, which says what its "
                "limbs sense and drive"
            )
        wiring = load_wiring(self.env if self.wiring is None else self.wiring)
        given = {"duration_s": self.duration, "episodes": self.episodes, "limit_s": self.limit}
        if self.budget is not None:
            given["budget"] = self.budget
        model = find(self.model)
        if self.scales:
            env = spec.make()
            wiring = wiring.with_scales(env)
            env.close()
        experiment = EnvExperiment.of_model(model, spec, wiring, omega=self.omega, **given)
        if self.fitness is not None:
            half = {"settle_s": 0.5 * self.duration}
            experiment = replace(experiment, objective=env_objective_named(self.fitness, **half))
        if self.settle is not None:
            if not isinstance(experiment.objective, Hopping):
                raise TegotaeError("--settle belongs to the fitness hopping")
            objective = replace(experiment.objective, settle_s=self.settle)
            experiment = replace(experiment, objective=objective)
        return experiment

    def _made_with(self) -> tuple[tuple[str, Any], ...]:
        """What the environment is made with.

        Raises:
            TegotaeError: for a setting that is no NAME=VALUE, or options of a MuJoCo model for
                something else.
        """
        from tegotae.envs.env_spec import EnvSpec

        is_model = EnvSpec(env=self.env).is_model
        found: dict[str, Any] = {}
        own = {"feet": list(self.feet) or None, "control_s": self.control}
        for name, value in own.items():
            if value is None:
                continue
            if not is_model:
                option = "feet" if name == "feet" else "control"
                raise TegotaeError(f"--{option} belongs to MuJoCo models, FILE.xml")
            found[name] = value
        for each in self.settings:
            name, equals, value = each.partition("=")
            if not equals or not name.isidentifier():
                raise TegotaeError(f"--settings {each!r} is no NAME=VALUE")
            if name in found:
                raise TegotaeError(f"{name} is given twice; leave --settings {each} out")
            try:
                found[name] = parse(value)
            except DamagedDocumentError:  # not JSON: a text
                found[name] = value
        return tuple(found.items())
