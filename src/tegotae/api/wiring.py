"""Controllers on the limbs of another simulator: options of their training, and the vanilla
baseline."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tegotae._support.engines import require_workers
from tegotae._support.errors import TegotaeError, require_all
from tegotae.api.controller import Changes
from tegotae.api.parameters import Values, with_options, with_own_values
from tegotae.api.results import MatplotlibFigure, Table
from tegotae.systems.env_documents import extras_of, stem_of
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import is_reference

if TYPE_CHECKING:  # which needs Gymnasium
    from tegotae.envs.env_spec import EnvSpec
    from tegotae.envs.wiring import Wiring
    from tegotae.training.environments.experiment import EnvExperiment


@dataclass(frozen=True, kw_only=True)
class EnvironmentOptions:
    """Wiring of limbs to an environment, and the way of their training there."""

    settings: tuple[str, ...] = ()
    """Further settings of the environment: NAME=VALUE, values as in JSON, such as ground=true; of a
    robot's file only those that differ."""
    wiring: str | None = None
    """Senses and commands of the limbs: a .toml or .json file; the environment's by default, if it
    comes with one."""
    omega: tuple[float, ...] = ()
    """Frequency of the oscillators [rad/s]; the wiring's by default, or else the model's. With
    several, every candidate has an episode at each, and one controller is learned for all."""
    evaluation_episodes: int = 0
    """Number of episodes of a fixed evaluation set, which selects the best controller. With it,
    every generation draws new starts."""
    scales: bool = False
    """Take scales that the wiring lacks from weight and length of the MuJoCo model."""
    workers: int | None = None
    """Worker processes that step environments, one per core by default; 0 for none. MuJoCo models
    do not need them."""
    limit_s: float = 60.0
    """Longest time for one step of an environment [s]; then the environment counts as hung."""

    def __post_init__(self) -> None:
        if self.workers is not None:
            require_workers(self.workers, least=0)

    def experiment(
        self, env: str, model: str, *, duration_s: float, fitness: str | None = None, **fields: Any
    ) -> EnvExperiment:
        """Return the experiment on an environment.

        Args:
            env: name of the environment.
            model: name of a model, or an architecture such as ART.
            duration_s: duration of an episode [s].
            fitness: hopping, return or a function's reference; hopping by default where it can be
                measured.
            fields: further fields of the experiment.

        Raises:
            TegotaeError: for values that do not fit together.
        """
        from tegotae.training.environments.experiment import EnvExperiment
        from tegotae.training.environments.objectives import env_objective_named

        if is_reference(model):
            raise TegotaeError(
                f"{model} cannot be trained on an environment; name a model, such as ART"
            )
        if fitness is not None:
            fields["objective"] = env_objective_named(fitness, settle_s=0.5 * duration_s)
        return EnvExperiment.from_recipe(
            recipe(model),
            *self.wired(env),
            omega=self.omega,
            duration_s=duration_s,
            evaluation_episodes=self.evaluation_episodes,
            limit_s=self.limit_s,
            **fields,
        )

    def wired(self, env: str) -> tuple[EnvSpec, Wiring]:
        """Return the environment of a name, and the wiring of its limbs.

        Raises:
            TegotaeError: if there is no wiring, or something of it cannot be used.
        """
        from tegotae.envs.robot_file import wired_environment

        return wired_environment(env, self.settings, wiring=self.wiring, scales=self.scales)


DEFAULT_ENVIRONMENT = EnvironmentOptions()
"""Options of an environment that a user leaves as they are."""


def environment_of(environment: EnvironmentOptions | Changes) -> EnvironmentOptions:
    """Return the options of an environment, or the default ones with changes."""
    if isinstance(environment, EnvironmentOptions):
        return environment
    return with_options(DEFAULT_ENVIRONMENT, environment)


_SHARES = np.linspace(0.5, 1.5, 7)
"""Frequencies that are tried by default, over the wiring's."""


@dataclass(frozen=True, repr=False, kw_only=True)
class VanillaBaseline(Table):
    """Fitness of a vanilla controller on an environment, over gain and frequency; `raw` is a
    `tegotae.training.scoring.VanillaSweep`."""

    experiment: EnvExperiment

    def _fill(self, folder: Path) -> list[Path]:
        """Write the map, its numbers and the best controller into a folder."""
        from tegotae.training.evolution import SEARCH
        from tegotae.training.learner import LearnedController
        from tegotae.training.run import save_controller

        sweep, experiment = self.raw, self.experiment
        row, column = sweep.best
        wiring = dataclasses.replace(experiment.wiring, omega=float(sweep.omega[column]))
        outcome = {
            "seed": 0,
            "best_fitness": float(sweep.fitness[row, column]),
            "ended": SEARCH,
            "generations": 0,
            "best_generation": 0,
        }
        best = save_controller(
            folder,
            dataclasses.replace(experiment, wiring=wiring, omegas=(), episodes=1),
            LearnedController(experiment.controller, sweep.sigma[[row]], outcome),
            {"swept": {"sigma": sweep.sigma.tolist(), "omega": sweep.omega.tolist()}},
            {},
        )
        return [*super()._fill(folder), best]


def _default_folder(env: str = "", **_: Any) -> Values:
    """Return the folder that is named as the environment."""
    return {"out": Path("runs") / f"{stem_of(env)}-vanilla"}


@with_own_values(_default_folder)
def wiring_baseline(
    env: str,
    *,
    model: str = "V-sector-w8",
    frequencies: Sequence[float] = (),
    duration_s: float = 12.0,
    fitness: str | None = None,
    environment: EnvironmentOptions | Changes = DEFAULT_ENVIRONMENT,
    out: Path | str | None = None,
) -> Table:
    """Sweep gain and frequency of the vanilla controller on an environment: the baseline for
    learned controllers.

    Args:
        env: a Gymnasium id such as Hopper-v5; FILE.py:FUNCTION or MODULE:FUNCTION that makes an
            environment; a MuJoCo model, FILE.xml or, in an installed package, PACKAGE:FILE.xml;
            hopper, leg or quadruped, which come with tegotae; or a robot's file, FILE.toml
            (`tegotae wiring suggest`).
        model: a pure V model, whose only weight is σ.
        frequencies: frequencies ω [rad/s]; by default those of the environment's option omega if it
            names several, or else seven, 0.5 to 1.5 times the wiring's.
        duration_s: duration of an episode [s].
        fitness: hopping, return, or FILE.py:FUNCTION; hopping by default where it can be measured.
        environment: wiring of the limbs, and settings of the environment.
        out: folder for the map and the best controller; nothing is written by default.

    Raises:
        MissingExtraError: without Gymnasium, or MuJoCo where it is needed.
        TegotaeError: for a name, a wiring or values that cannot be.

    Example:
        >>> wiring_baseline("leg", frequencies=(8.0, 10.0), duration_s=6.0).plot()  # doctest: +SKIP
    """
    require_all(extras_of(env))
    options = environment_of(environment)
    from tegotae.training.scoring import sweep_vanilla

    experiment = options.experiment(env, model, duration_s=duration_s, fitness=fitness)
    experiment.check()
    omega = tuple(frequencies) or experiment.omegas
    if not omega:
        assert experiment.omega is not None
        omega = tuple(float(f"{x:.3g}") for x in _SHARES * experiment.omega)
    sweep = sweep_vanilla(experiment, omega, options.workers)
    table, (row, column) = sweep.table(), sweep.best

    def draw() -> dict[str, MatplotlibFigure]:
        from tegotae.figures.maps import vanilla_sweep_figure
        from tegotae.figures.style import literal_text

        label = "fitness" if fitness is None else f"fitness: {fitness}"
        return {"map": vanilla_sweep_figure(sweep, fitness=literal_text(label))}

    return VanillaBaseline(
        raw=sweep,
        experiment=experiment,
        title=f"best: σ {sweep.sigma[row]:.3g} rad/(s N) at ω {sweep.omega[column]:g} rad/s, "
        f"fitness {sweep.fitness[row, column]:.4f}",
        notes=sweep.advice(),
        rows=table,
        views=[sweep.best_gains()],
        data={"environment": experiment.spec.env, "rows": table.to_dict("records")},
        draw=draw,
    )
