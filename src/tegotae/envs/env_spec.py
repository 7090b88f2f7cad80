"""Specify where limbs are trained: an environment by its id, a function that makes one, or a
model."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from tegotae._support.documents import DamagedDocumentError, Json, parse_json, texts_in
from tegotae._support.errors import TegotaeError, other_code, require, unknown
from tegotae.envs._types import AnyEnv
from tegotae.envs.mujoco.settings import PACKAGED, ModelSettings, located
from tegotae.envs.wiring import Wiring
from tegotae.systems.env_documents import is_mujoco_model
from tegotae.systems.registry import is_reference, load_object, require_named, source_of


@dataclass(frozen=True, kw_only=True)
class EnvSpec:
    """An environment by name, so that files and worker processes can make it.

    Args:
        env: a Gymnasium id such as `Hopper-v5`; `FILE.py:FUNCTION` or `MODULE:FUNCTION` that makes
            an environment; a MuJoCo model, `FILE.xml`, or `PACKAGE:FILE.xml` of another installed
            package; or one of this package: `hopper`, `leg` or `quadruped`.
        settings: what the environment is made with, pairs of name and value.

    Example:
        >>> EnvSpec(env="CartPole-v1").make().spec.id
        'CartPole-v1'
    """

    env: str
    settings: tuple[tuple[str, Json], ...] = ()

    @classmethod
    def of_document(cls, env: str, settings: Mapping[str, Json], document: str) -> EnvSpec:
        """Return the environment that a document names: a registered one, or code that the user
        named.

        Args:
            env: its name.
            settings: its settings.
            document: the document, for errors.

        Raises:
            TegotaeError: for code that the user did not name (`require_named`).
        """
        spec = cls(env=env, settings=tuple(settings.items()))
        if not spec.is_model:
            for text in texts_in([env, settings]):
                require_named(text, document)
        return spec

    @property
    def is_model(self) -> bool:
        """True if it is a MuJoCo model, whose physics needs no environment around it."""
        return is_mujoco_model(self.env)

    @property
    def file(self) -> Path | None:
        """The user's file that it comes from, if any."""
        if self.is_model:
            return None if self.env in PACKAGED else located(self.env)
        return source_of(self.env) if is_reference(self.env) else None

    @property
    def model_settings(self) -> ModelSettings:
        """The settings of a MuJoCo model.

        Raises:
            TegotaeError: for settings that it does not have.
            MissingExtraError: without MuJoCo.
        """
        from tegotae.envs.mujoco.env import model_settings_of

        return model_settings_of(None, {"model": self.env, **dict(self.settings)})

    def for_wiring(self, wiring: Wiring) -> EnvSpec:
        """Return the environment; a MuJoCo model gets the feet and the control period of a wiring.

        Raises:
            TegotaeError: for a control period that is not the wiring's.
        """
        if not self.is_model:
            return self
        settings, required = dict(self.settings), dict[str, Json]()
        if wiring.contact_bodies:
            required["feet"] = feet = list(wiring.contact_bodies)
            env_feet = settings.get("feet", feet)
            if isinstance(env_feet, list) and not all(foot in env_feet for foot in feet):
                raise TegotaeError(
                    f"the wiring's feet are {', '.join(feet)}, and the environment's "
                    f"{', '.join(map(str, env_feet))}; leave --feet out"
                )
        if wiring.step_s is not None:
            required["control_s"] = float(wiring.step_s)
            if settings.get("control_s", required["control_s"]) != required["control_s"]:
                raise TegotaeError(
                    f"the control period is {settings['control_s']:g} s, and the wiring's step_s "
                    f"{wiring.step_s:g} s; leave one of them out"
                )
        return replace(self, settings=tuple({**required, **settings}.items()))

    def make(self) -> AnyEnv:
        """Make the environment.

        Raises:
            TegotaeError: if there is none of this name, or it cannot be made so.
            MissingExtraError: without Gymnasium, or MuJoCo where it is needed.
        """
        gymnasium = require("gymnasium", "gym")
        if self.is_model:
            require("mujoco", "mujoco")
            from tegotae.envs.mujoco.env import ModelEnv

            return ModelEnv(self.model_settings)
        settings = dict(self.settings)
        if is_reference(self.env):
            maker = load_object(self.env, (_Function, type), "function that makes an environment")
        else:
            importlib.import_module("tegotae.envs")  # which registers those of this package
            if self.env not in gymnasium.registry:
                if self.env.endswith(".py"):
                    raise TegotaeError(
                        f"{self.env} names no environment; name the function in it that makes one, "
                        f"{self.env}:FUNCTION"
                    )
                raise unknown("environment", self.env, [*gymnasium.registry, *PACKAGED])
            maker = partial(gymnasium.make, self.env)
        with other_code(f"{self.env} cannot be made"):
            env = maker(**settings)
        if not isinstance(env, gymnasium.Env):
            raise TegotaeError(
                f"{self.env} made a {type(env).__name__}; it must make a Gymnasium environment"
            )
        return env


def settings_of(texts: Iterable[str]) -> dict[str, Json]:
    """Return the settings of an environment from texts NAME=VALUE.

    Raises:
        TegotaeError: for a text that is none, or a name twice.

    Example:
        >>> settings_of(["noise=0.02", "ground=true"])
        {'noise': 0.02, 'ground': True}
    """
    settings: dict[str, Json] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise TegotaeError(f"--settings {text!r} is no NAME=VALUE")
        if name in settings:
            raise TegotaeError(f"{name} is given twice; leave --settings {text} out")
        try:
            settings[name] = parse_json(value)
        except DamagedDocumentError:  # not JSON: a text
            settings[name] = value
    return settings


_Function = type(lambda: None)
