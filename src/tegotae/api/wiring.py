"""Controllers on the limbs of another simulator: how they are trained there, and the vanilla
baseline."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae.api.controller import Changes
from tegotae.api.parameters import Values, in_shell, with_options
from tegotae.api.results import Table
from tegotae.systems.env_documents import extras_of, is_mujoco_model, is_robot_file
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import is_reference

if TYPE_CHECKING:  # which needs Gymnasium
    from matplotlib import figure

    from tegotae.envs.env_spec import EnvSpec
    from tegotae.envs.wiring import Wiring
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.scoring import VanillaSweep


ENVIRONMENTS = (
    "A name is a Gymnasium id such as Hopper-v5; FILE.py:FUNCTION or MODULE:FUNCTION that makes an "
    "environment; a MuJoCo model, FILE.xml or, in an installed package, PACKAGE:FILE.xml; "
    "hopper, leg or quadruped, which come with tegotae; or a robot's file, FILE.toml (tegotae "
    "wiring suggest)."
)
"""Meaning of an environment's name, for help."""


@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """Settings of an environment."""

    settings: tuple[str, ...] = ()
    """Further settings of the environment: NAME=VALUE, values as in JSON, such as ground=true; of a
    robot's file those that differ."""

    def spec(self, env: str, feet: Sequence[str] = ()) -> EnvSpec:
        """Return the environment of a name.

        Args:
            env: the name.
            feet: bodies or geoms of a MuJoCo model that touch the ground, if they are named.

        Raises:
            TegotaeError: for a setting that is no NAME=VALUE, or a robot's file that is none.
        """
        from tegotae.envs.env_spec import EnvSpec, settings_of
        from tegotae.envs.robot_file import load_robot

        feet_text = [f"feet={json.dumps(feet)}"] if feet else []
        settings = settings_of([*feet_text, *self.settings])
        if is_robot_file(env):
            return load_robot(env, settings)[0]
        return EnvSpec(env=env, settings=tuple(settings.items()))


@dataclass(frozen=True, kw_only=True)
class EnvironmentOptions(ModelOptions):
    """Wiring of limbs to an environment, and the way of their training there."""

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
    """Worker processes that step environments, one a core by default; 0 for none. MuJoCo models do
    not need them."""
    limit_s: float = 60.0
    """Longest time for one step of an environment [s]; then the environment counts as hung."""

    def experiment(
        self,
        env: str,
        model: str,
        *,
        duration_s: float,
        fitness: str | None = None,
        **overrides: Any,
    ) -> EnvExperiment:
        """The experiment on an environment.

        Args:
            env: the environment's name.
            model: the controller: a model's name, or an architecture such as ART.
            duration_s: length of an episode [s].
            fitness: the objective: hopping, return or a function's reference; hopping where it can
                be measured if None.
            given: further fields of the experiment.

        Raises:
            TegotaeError: for what does not fit together.
        """
        from tegotae.training.environments.experiment import EnvExperiment
        from tegotae.training.environments.objectives import env_objective_named

        if is_reference(model):
            raise TegotaeError(
                f"{model} cannot be trained on an environment; name a model, such as ART"
            )
        spec, wiring = self.wired(env)
        experiment = EnvExperiment.from_recipe(
            recipe(model),
            spec,
            wiring,
            omega=self.omega,
            duration_s=duration_s,
            evaluation_episodes=self.evaluation_episodes,
            limit_s=self.limit_s,
            **overrides,
        )
        if fitness is None:
            return experiment
        objective = env_objective_named(fitness, settle_s=0.5 * duration_s)
        return dataclasses.replace(experiment, objective=objective)

    def wired(self, env: str) -> tuple[EnvSpec, Wiring]:
        """The environment of a name, and the wiring of its limbs.

        Raises:
            TegotaeError: if there is no wiring, or something of it cannot be used.
        """
        from tegotae.envs.wiring import load_wiring, packaged

        spec, robot = self.spec(env), is_robot_file(env)
        if robot and self.wiring is not None:
            raise TegotaeError(f"{env} has a wiring; leave --wiring out, or name its model")
        if self.wiring is None and not robot and env not in packaged():
            spec.make().close()  # a name with a slip lacks more than a wiring
            first = f"; tegotae wiring suggest {env} writes a robot's file" if spec.is_model else ""
            raise TegotaeError(
                f"no wiring is given for {env}; write --wiring FILE.toml, which says what its "
                f"limbs sense and drive{first}"
            )
        wiring = load_wiring(env if self.wiring is None else self.wiring)
        spec = spec.for_wiring(wiring)
        if self.scales:
            environment = spec.make()
            wiring = wiring.with_scales(environment)
            environment.close()
        return spec, wiring


def environment_of(environment: EnvironmentOptions | Changes | None) -> EnvironmentOptions:
    """Return the options of an environment, of which some may be given by name."""
    if environment is None or isinstance(environment, EnvironmentOptions):
        return environment or EnvironmentOptions()
    return with_options(EnvironmentOptions(), environment)


def stem_of(env: str) -> str:
    """What an environment is called, as a part of a file's name.

    Example:
        >>> stem_of("my_leg.xml"), stem_of("robots:leg.xml"), stem_of("my_robot.py:make")
        ('my_leg', 'leg', 'my_robot')
    """
    module, _, last = env.rpartition(":")
    return Path(last if is_mujoco_model(env) else module or env).stem


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


def _sweep_table(sweep: VanillaSweep) -> pd.DataFrame:
    """A row a gain and frequency."""
    sigma, omega = np.meshgrid(sweep.sigma, sweep.omega, indexing="ij")
    columns = {"sigma_rad_per_s_n": sigma, "omega_rad_per_s": omega, "fitness": sweep.fitness}
    columns |= {"cot_inverse_m_per_j": sweep.cot_inverse, "failed": sweep.failed.astype(int)}
    return pd.DataFrame({name: values.ravel() for name, values in columns.items()})


def _best_gains(sweep: VanillaSweep) -> pd.DataFrame:
    """The best gain of each frequency, for people."""
    best = np.argmax(sweep.fitness, axis=0)
    columns = {
        "ω [rad/s]": [f"{omega:g}" for omega in sweep.omega],
        "best σ": [f"{sigma:.3g}" for sigma in sweep.sigma[best]],
        "fitness": [f"{fitness:.4f}" for fitness in sweep.fitness.max(axis=0)],
        "fitness at σ = 0": [f"{fitness:.4f}" for fitness in sweep.fitness[0]],
        "failed": [f"{share:.0%}" for share in sweep.failed.mean(axis=0)],
    }
    return pd.DataFrame(columns).set_index("ω [rad/s]")


def _advice(sweep: VanillaSweep) -> list[str]:
    """What to try where feedback does not help."""
    row, column = sweep.best
    sentences = []
    if np.isfinite(sweep.cot_inverse).any() and not np.nanmax(sweep.cot_inverse) > 0.0:
        sentences.append(
            "Nothing hops: CoT⁻¹ is 0 everywhere. Enlarge the pushes, release it higher "
            "(--settings release_m=0.1), or use --fitness return."
        )
    if row == 0:
        sentences.append(
            "No gain is better than zero: feedback does not help the bare rhythm. Check rests "
            "and pushes of the wiring first."
        )
    elif column in (0, len(sweep.omega) - 1) and len(sweep.omega) > 1:
        sentences.append("The best ω is the last one tried: --frequencies beyond it may do better.")
    return sentences


def _baseline_values(env: str = "", **_: Any) -> Values:
    """Folder that is named as the environment."""
    return {"out": Path("runs") / f"{stem_of(env)}-vanilla"}


@in_shell(
    defaults=_baseline_values,
    values={"environment": EnvironmentOptions()},
    names=ENVIRONMENTS,
    examples={"": "my_leg.xml"},
)
def wiring_baseline(
    env: str,
    *,
    model: str = "V-sector-w8",
    frequencies: Sequence[float] = (),
    duration_s: float = 12.0,
    fitness: str | None = None,
    environment: EnvironmentOptions | Changes | None = None,
    out: Path | str | None = None,
) -> Table:
    """Sweep gain and frequency of the vanilla controller on an environment: the baseline for
    learned controllers.

    Args:
        env: name of the environment.
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
    table, (row, column) = _sweep_table(sweep), sweep.best

    def draw() -> dict[str, figure.Figure]:
        from tegotae.figures.maps import vanilla_sweep_figure
        from tegotae.figures.style import literal_text

        label = "fitness" if fitness is None else f"fitness: {fitness}"
        return {"map": vanilla_sweep_figure(sweep, fitness=literal_text(label))}

    return VanillaBaseline(
        raw=sweep,
        experiment=experiment,
        title=f"best: σ {sweep.sigma[row]:.3g} rad/(s N) at ω {sweep.omega[column]:g} rad/s, "
        f"fitness {sweep.fitness[row, column]:.4f}",
        notes=_advice(sweep),
        rows=table,
        views=[_best_gains(sweep)],
        data={"environment": experiment.spec.env, "rows": table.to_dict("records")},
        draw=draw,
    )
