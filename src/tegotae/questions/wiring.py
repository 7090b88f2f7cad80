"""Controllers on the limbs of another simulator: how they are trained there, a first wiring of a
MuJoCo model, and the vanilla baseline."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae.questions.answer import DrawnAnswer, TableAnswer
from tegotae.questions.question import Names, question
from tegotae.systems.designs import Design, design, is_design
from tegotae.systems.env_task import extras_of, is_mujoco_model
from tegotae.systems.laws import ShortLaw, short_law
from tegotae.systems.models import Model, find
from tegotae.systems.user_objects import is_reference

if TYPE_CHECKING:  # which needs Gymnasium
    from matplotlib.figure import Figure

    from tegotae.envs.env_spec import EnvSpec
    from tegotae.envs.mujoco.suggesting import Suggestion
    from tegotae.envs.wiring import Wiring
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.scoring import VanillaSweep


@dataclass(frozen=True, kw_only=True)
class Environments(Names):
    """Environments by name."""

    NAMED = (
        "A name is a Gymnasium id such as Hopper-v5; FILE.py:FUNCTION or MODULE:FUNCTION that "
        "makes an environment; a MuJoCo model, FILE.xml or, in an installed package, "
        "PACKAGE:FILE.xml; or hopper, leg or quadruped, which come with tegotae."
    )

    def named(self, *names: Any) -> Sequence[str]:
        """The names.

        Raises:
            MissingExtraError: without Gymnasium, or MuJoCo where it is needed.
        """
        for env in names:
            require_all(extras_of(env))
        return names


@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """What an environment is made with."""

    feet: tuple[str, ...] = ()
    """Bodies or geoms of a MuJoCo model that touch the ground; by default those of the wiring, or
    else the lowest ones at the end of a chain."""
    settings: tuple[str, ...] = ()
    """Further settings of the environment: NAME=VALUE, values as in JSON, such as ground=true."""

    def spec(self, env: str, control_s: float | None = None) -> EnvSpec:
        """The environment of a name.

        Raises:
            TegotaeError: for a setting that is no NAME=VALUE, or an option of MuJoCo models for
                something else.
        """
        from tegotae.envs.env_spec import EnvSpec, settings_of

        own: dict[str, Any] = {"feet": list(self.feet) or None, "control_s": control_s}
        own = {name: value for name, value in own.items() if value is not None}
        if own and not is_mujoco_model(env):
            option = next(iter(own)).removesuffix("_s")
            raise TegotaeError(f"--{option} belongs to MuJoCo models, FILE.xml")
        settings = settings_of(self.settings)
        for name in own.keys() & settings.keys():
            raise TegotaeError(f"{name} is given twice; leave --settings {name} out")
        return EnvSpec(env=env, settings=tuple((own | settings).items()))


@dataclass(frozen=True, kw_only=True)
class OnEnvironment(ModelOptions):
    """How limbs are trained on an environment."""

    wiring: str | None = None
    """Senses and commands of the limbs: a .toml or .json file; the environment's by default, if it
    comes with one."""
    omega: tuple[float, ...] = ()
    """Frequency of the oscillators [rad/s]; the wiring's by default, or else the model's. With
    several, every candidate has an episode at each, and one controller is learned for all."""
    evaluation_episodes: int = 0
    """Number of episodes of a fixed evaluation set, which selects the best controller. With it,
    every generation draws new starts."""
    control_s: float | None = None
    """Control period of a MuJoCo model [s]: an action is held for that time; the environment's by
    default."""
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
        **given: Any,
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
        experiment = EnvExperiment.of_model(
            _trainable(model),
            spec,
            wiring,
            omega=self.omega,
            duration_s=duration_s,
            evaluation_episodes=self.evaluation_episodes,
            limit_s=self.limit_s,
            **given,
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

        spec = self.spec(env, self.control_s)
        if self.wiring is None and env not in packaged():
            spec.make().close()  # a name with a slip lacks more than a wiring
            first = f"; tegotae wiring suggest {env} writes a first one" if spec.is_model else ""
            raise TegotaeError(
                f"no wiring is given for {env}; write --wiring FILE.toml, which says what its "
                f"limbs sense and drive{first}"
            )
        wiring = load_wiring(env if self.wiring is None else self.wiring)
        spec = spec.for_wiring(wiring)
        if self.scales:
            made = spec.make()
            wiring = wiring.with_scales(made)
            made.close()
        return spec, wiring


def _trainable(name: str) -> Model | ShortLaw | Design:
    """What has a controller to be trained, by its name."""
    return short_law(name) or (design(name) if is_design(name) else find(name))


def stem_of(env: str) -> str:
    """What an environment is called, as a part of a file's name.

    Example:
        >>> stem_of("my_leg.xml"), stem_of("robots:leg.xml"), stem_of("my_robot.py:make")
        ('my_leg', 'leg', 'my_robot')
    """
    module, _, last = env.rpartition(":")
    return Path(last if is_mujoco_model(env) else module or env).stem


@dataclass(frozen=True, kw_only=True)
class ModelFileOptions(ModelOptions):
    """What is known of the model, and where what follows from it is written."""

    out: Path
    """The file (.toml; a wiring's may be .json), which must not be there yet."""

    @classmethod
    def options_of(cls, env: str) -> ModelFileOptions:
        """A file that is named as the model."""
        return cls(out=Path(f"{stem_of(env)}.toml"))


@dataclass(frozen=True, repr=False, kw_only=True)
class ModelFile(TableAnswer):
    """What follows from a model, every entry with its reason; in memory until it is saved."""

    ENDING = ".toml"

    def save(self, folder: Path | str, format: str = "toml") -> list[Path]:
        """Write the file of that name; none that is there is written over.

        Raises:
            TegotaeError: for another ending, or if it is there or cannot be written.
        """
        file = Path(folder)
        if file.exists():
            raise TegotaeError(f"{file} exists already; name another file with --out")
        self._write(file)
        return [file]

    def _write(self, file: Path) -> None:
        raise NotImplementedError


@dataclass(frozen=True, repr=False, kw_only=True)
class SuggestedWiring(ModelFile):
    """A first wiring, .toml or .json. `raw` is a `tegotae.envs.mujoco.suggesting.Suggestion`, and
    the document that of the wiring."""

    def figures(self) -> dict[str, Figure]:
        """The workspace of feet that are commanded to places; none of joints."""
        from tegotae.figures.workspace import workspace_figure

        return {} if self.raw.legs is None else {"workspace": workspace_figure(self.raw)}

    def _write(self, file: Path) -> None:
        from tegotae.envs.wiring import save_wiring

        save_wiring(self.raw.wiring, file, reasons=self.raw.reasons)


def _entries(suggestion: Suggestion) -> pd.DataFrame:
    """A row an entry that has a reason."""
    wiring, rows = suggestion.wiring, []
    for name, reason in suggestion.reasons.items():
        owner, _, entry = name.rpartition(".")
        if owner.startswith("limbs["):
            limb = wiring.limbs[int(owner[6:-1])]
            value = limb.senses[entry] if entry in limb.senses else getattr(limb, entry)
            name = f"{', '.join(limb.entries)}: {entry}"
        elif owner == "scales":
            value = wiring.scales[entry]
        else:
            value = getattr(getattr(wiring, owner) if owner else wiring, entry)
        rows.append((name, _said(value), reason))
    return pd.DataFrame(rows, columns=["entry", "value", "reason"])


def _said(value: Any) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4g}" if isinstance(value, float) else ", ".join(map(_said, value))


@question(
    subjects=Environments,
    kinds={"option": lambda: ModelFileOptions.options_of("my_leg.xml")},
)
def wiring_suggest(env: str, options: ModelFileOptions) -> SuggestedWiring:
    """Suggest a wiring for a MuJoCo model of your own: feet, limbs, pushes, scales, rest length.

    Every entry has its reason beside it, in the terminal and as a comment in the file. The wiring
    is a first guess: correct every entry that you know better.

    Example:
        >>> wiring_suggest("my_leg.xml").save("my_leg.toml")  # doctest: +SKIP
    """
    from tegotae.envs.mujoco.suggesting import suggest_wiring
    from tegotae.envs.mujoco.suggesting_legs import suggest_legs
    from tegotae.envs.wiring import wiring_document

    if not is_mujoco_model(env):
        raise TegotaeError(
            f"{env} is no MuJoCo model (FILE.xml); for another environment write the wiring by "
            "hand, and check it with tegotae.envs.check_wiring"
        )
    settings = options.spec(env).model_settings
    suggestion = suggest_legs(settings) if settings.legs else suggest_wiring(settings)
    where = [env, "--wiring", str(options.out)]
    if options.settings:
        where += ["--settings", *options.settings]
    if settings.legs:
        ways = ["wiring transfer zoo:AR-rF+range@quadruped-c --env", "train AR@quadruped-c --env"]
    else:
        ways = ["wiring baseline", "train ART --env"]
    if suggestion.on_rail:
        where += ["--fitness", "hopping"]
    elif len(suggestion.wiring.limbs) > 1 and not settings.legs:
        # What hops ahead, or walks, is paid for distance; CoT⁻¹ of hops alone often stays 0.
        where += ["--fitness", "return"]
    table = _entries(suggestion)
    return SuggestedWiring(
        raw=suggestion,
        table=table,
        shown=[table.set_index("entry")],
        remarks=[
            *suggestion.remarks,
            "Next:",
            *(f"tegotae {way} {shlex.join(where)}" for way in ways),
        ],
        data=wiring_document(suggestion.wiring),
    )


_SHARES = np.linspace(0.5, 1.5, 7)
"""Frequencies that are tried by default, over the wiring's."""


@dataclass(frozen=True, kw_only=True)
class BaselineOptions(OnEnvironment):
    """What is swept on an environment, and where the map is written."""

    model: str = "V-sector-w8"
    """A pure V model, whose only weight is σ."""
    frequencies: tuple[float, ...] = ()
    """Frequencies ω [rad/s]; by default those of --omega if it names several, or else seven, 0.5 to
    1.5 times the wiring's."""
    duration_s: float = 12.0
    """Duration of an episode [s]."""
    fitness: str | None = None
    """Fitness: hopping, return, or FILE.py:FUNCTION; hopping by default where it can be
    measured."""
    out: Path
    """Folder for the map and the best controller."""

    @classmethod
    def options_of(cls, env: str) -> BaselineOptions:
        """A folder that is named as the environment."""
        return cls(out=Path("runs") / f"{stem_of(env)}-vanilla")


@dataclass(frozen=True, repr=False, kw_only=True)
class VanillaBaseline(DrawnAnswer):
    """What a vanilla controller reaches on an environment, over gain and frequency; `raw` is a
    `tegotae.training.scoring.VanillaSweep`."""

    experiment: EnvExperiment

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
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
            Path(folder),
            dataclasses.replace(experiment, wiring=wiring, omegas=(), episodes=1),
            LearnedController(experiment.controller, sweep.sigma[[row]], outcome),
            {"swept": {"sigma": sweep.sigma.tolist(), "omega": sweep.omega.tolist()}},
            {},
        )
        return [*super().save(folder, format), best]


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
    said = []
    if np.isfinite(sweep.cot_inverse).any() and not np.nanmax(sweep.cot_inverse) > 0.0:
        said.append(
            "Nothing hops: CoT⁻¹ is 0 everywhere. Enlarge the pushes, release it higher "
            "(--settings release_m=0.1), or use --fitness return."
        )
    if row == 0:
        said.append(
            "No gain is better than zero: feedback does not help the bare rhythm. Check rests "
            "and pushes of the wiring first."
        )
    elif column in (0, len(sweep.omega) - 1) and len(sweep.omega) > 1:
        said.append("The best ω is the last one tried: --frequencies beyond it may do better.")
    return said


@question(
    subjects=Environments,
    kinds={"option": lambda: BaselineOptions.options_of("my_leg.xml")},
)
def wiring_baseline(env: str, options: BaselineOptions) -> VanillaBaseline:
    """Sweep gain and frequency of the vanilla controller on an environment: the baseline for
    learned controllers.

    Example:
        >>> wiring_baseline("leg", frequencies=(8.0, 10.0), duration=6.0).plot()  # doctest: +SKIP
    """
    from tegotae.training.scoring import sweep_vanilla

    experiment = options.experiment(
        env, options.model, duration_s=options.duration_s, fitness=options.fitness
    )
    experiment.check()
    omega = options.frequencies or experiment.omegas
    if not omega:
        assert experiment.omega is not None
        omega = tuple(float(f"{x:.3g}") for x in _SHARES * experiment.omega)
    sweep = sweep_vanilla(experiment, omega, options.workers)
    table, (row, column) = _sweep_table(sweep), sweep.best

    def drawn() -> dict[str, Figure]:
        from tegotae.figures.maps import vanilla_sweep_figure
        from tegotae.figures.style import literal

        named = "fitness" if options.fitness is None else f"fitness: {options.fitness}"
        return {"map": vanilla_sweep_figure(sweep, fitness=literal(named))}

    return VanillaBaseline(
        raw=sweep,
        experiment=experiment,
        outcome=f"best: σ {sweep.sigma[row]:.3g} rad/(s N) at ω {sweep.omega[column]:g} rad/s, "
        f"fitness {sweep.fitness[row, column]:.4f}",
        remarks=_advice(sweep),
        table=table,
        shown=[_best_gains(sweep)],
        data={"environment": experiment.spec.env, "rows": table.to_dict("records")},
        drawn=drawn,
    )
