"""Options of a training on an environment: which one, and what of it limbs sense and drive."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from tegotae._support.documents import DamagedDocumentError, Json, parse
from tegotae._support.errors import TegotaeError, require_all
from tegotae.cli.options import UNSET
from tegotae.systems.env_task import extras_of
from tegotae.systems.models import find
from tegotae.systems.user_objects import is_reference

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment

_MODELS = tyro.conf.arg(help_behavior_hint="(default: the environment's, if it comes with one)")
_OWN = tyro.conf.arg(help_behavior_hint="(default: the environment's)")
_WIRINGS_OMEGA = tyro.conf.arg(help_behavior_hint="(default: the wiring's, or else the model's)")
_CORES = tyro.conf.arg(help_behavior_hint="(default: one per core)")
_LIMIT = tyro.conf.arg(help_behavior_hint="(default: 60)")


@dataclass(frozen=True, kw_only=True)
class EnvOptions:
    """Where limbs are trained, if not on the engine; all but `--env` belong to it."""

    HEADING = "Environment (instead of this package's engine)"

    env: Annotated[str | None, UNSET] = None
    """The environment: a Gymnasium id such as Hopper-v5; FILE.py:FUNCTION or MODULE:FUNCTION that
    makes one; a MuJoCo model, FILE.xml or, in an installed package, PACKAGE:FILE.xml; or hopper,
    leg or quadruped, which come with tegotae."""
    wiring: Annotated[str | None, _MODELS] = None
    """Senses and commands of the limbs: a .toml or .json file."""
    omega: Annotated[tuple[float, ...], _WIRINGS_OMEGA] = ()
    """Frequency of the oscillators [rad/s]. With several, every candidate has an episode at each,
    and one controller is learned for all."""
    evaluation_episodes: Annotated[int, tyro.conf.arg(help_behavior_hint="(default: none)")] = 0
    """Number of episodes of a fixed evaluation set, which selects the best controller. With it,
    every generation draws new starts."""
    feet: Annotated[tuple[str, ...], UNSET] = ()
    """Bodies or geoms of a MuJoCo model whose contact forces are observed; the wiring's by
    default."""
    control: Annotated[float | None, _OWN] = None
    """Control period of a MuJoCo model [s]: an action is held for that time."""
    settings: Annotated[tuple[str, ...], UNSET] = ()
    """Further settings of the environment: NAME=VALUE, values as in JSON."""
    scales: bool = False
    """Take scales that the wiring lacks from weight and length of the MuJoCo model."""
    workers: Annotated[int | None, _CORES] = None
    """Worker processes that step environments; 0 for none. MuJoCo models do not need them."""
    limit: Annotated[float | None, _LIMIT] = None
    """Longest time for one step of an environment [s]; then the environment counts as hung."""

    def require_engine(self) -> None:
        """Raise `TegotaeError` for an option of environments where none is named."""
        for field in dataclasses.fields(EnvOptions):
            if getattr(self, field.name) != field.default:
                option = field.name.replace("_", "-")
                raise TegotaeError(f"--{option} belongs to environments; give --env, too")

    @property
    def called(self) -> str:
        """The environment's part of a folder's name."""
        from tegotae.envs.env_spec import EnvSpec

        assert self.env is not None
        function = not EnvSpec(env=self.env).is_model and self.env.rpartition(":")[0]
        return Path(function or self.env).stem

    def experiment_of(
        self,
        model: str,
        *,
        duration_s: float,
        fitness: str | None,
        hopping: dict[str, Any],
        **given: Any,
    ) -> EnvExperiment:
        """The experiment on the environment.

        Args:
            model: the controller: a model's name, or an architecture such as ART.
            duration_s: length of an episode [s].
            fitness: the objective: hopping, return or a function's reference; hopping where it can
                be measured if None.
            hopping: settings of the objective hopping.
            given: further fields of the experiment.

        Raises:
            MissingExtraError: without Gymnasium, or MuJoCo where it is needed.
            TegotaeError: for what does not fit together.
        """
        assert self.env is not None
        require_all(extras_of(self.env))
        from tegotae.envs.env_spec import EnvSpec
        from tegotae.envs.wiring_file import load_wiring, packaged
        from tegotae.training.environments.experiment import EnvExperiment
        from tegotae.training.environments.objectives import Hopping, env_objective_named

        if is_reference(model):
            raise TegotaeError(
                f"{model} cannot be trained on an environment; name a model, such as ART"
            )
        is_model = EnvSpec(env=self.env).is_model
        given_to_it = made_with(self.feet, self.control, self.settings, is_model=is_model)
        spec = EnvSpec(env=self.env, settings=given_to_it)
        if self.wiring is None and self.env not in packaged():
            spec.make().close()  # a name with a slip lacks more than a wiring
            first = f"; tegotae wiring suggest {self.env} writes a first one" if is_model else ""
            raise TegotaeError(
                f"no wiring is given for {self.env}; write --wiring FILE.toml, which says what its "
                f"limbs sense and drive{first}"
            )
        wiring = load_wiring(self.env if self.wiring is None else self.wiring)
        spec = spec.for_wiring(wiring)
        own = find(model)
        if self.scales:
            env = spec.make()
            wiring = wiring.with_scales(env)
            env.close()
        given = {"duration_s": duration_s, **given}
        if self.evaluation_episodes:
            given["evaluation_episodes"] = self.evaluation_episodes
        if self.limit is not None:
            given["limit_s"] = self.limit
        experiment = EnvExperiment.of_model(own, spec, wiring, omega=self.omega, **given)
        if fitness is not None:
            objective = env_objective_named(fitness, settle_s=0.5 * duration_s)
            experiment = replace(experiment, objective=objective)
        if hopping:
            if not isinstance(experiment.objective, Hopping):
                option = {"settle_s": "settle", "follow_omega": "cot-only"}
                name = next(iter(hopping))
                raise TegotaeError(f"--{option.get(name, name)} belongs to the fitness hopping")
            objective = replace(experiment.objective, **hopping)
            experiment = replace(experiment, objective=objective)
        return experiment


def made_with(
    feet: Sequence[str], control_s: float | None, settings: Sequence[str], *, is_model: bool
) -> tuple[tuple[str, Json], ...]:
    """What options make an environment with.

    Args:
        feet: of a MuJoCo model.
        control_s: of a MuJoCo model [s].
        settings: NAME=VALUE each.
        is_model: whether it is a MuJoCo model.

    Raises:
        TegotaeError: for a setting that is no NAME=VALUE, or options of a MuJoCo model for
            something else.
    """
    found: dict[str, Json] = {}
    own = {"feet": list(feet) or None, "control_s": control_s}
    for name, value in own.items():
        if value is None:
            continue
        if not is_model:
            option = "feet" if name == "feet" else "control"
            raise TegotaeError(f"--{option} belongs to MuJoCo models, FILE.xml")
        found[name] = value
    for each in settings:
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
