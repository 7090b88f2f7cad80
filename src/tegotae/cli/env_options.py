"""Options of a training on an environment: which one, and what of it limbs sense and drive."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from tegotae._support.errors import TegotaeError, require_all
from tegotae.cli.options import UNSET
from tegotae.questions.wiring import OnEnvironment, stem_of
from tegotae.systems.env_task import extras_of

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
        assert self.env is not None
        return stem_of(self.env)

    def experiment_of(self, model: str, **given: Any) -> EnvExperiment:
        """The experiment on the environment (`OnEnvironment.experiment`)."""
        assert self.env is not None
        require_all(extras_of(self.env))
        own = {field.name: field.name.removesuffix("_s") for field in fields(OnEnvironment)}
        values = {name: getattr(self, option) for name, option in own.items()}
        if values["limit_s"] is None:
            del values["limit_s"]
        return OnEnvironment(**values).experiment(self.env, model, **given)
