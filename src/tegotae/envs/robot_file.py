"""A robot's file: written from a model and a first wiring of it, read as environment and wiring."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from tegotae._support.documents import Json
from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae._support.part_code import code_of_file
from tegotae.envs.env_spec import EnvSpec, settings_of
from tegotae.envs.wiring import (
    Wiring,
    load_wiring,
    packaged,
    toml_of,
    wiring_document,
    wiring_of,
)
from tegotae.systems.env_documents import ROBOT_FORMAT, is_robot_file, robot_document


def load_robot(
    path: Path | str, settings: Mapping[str, Json] | None = None
) -> tuple[EnvSpec, Wiring]:
    """Read a robot's file.

    Args:
        path: what `tegotae wiring suggest` wrote, FILE.toml.
        settings: settings of the environment in place of the file's.

    Returns:
        the environment, and the wiring of its limbs.

    Raises:
        TegotaeError: for a file that is no robot's, a model that is not there or has changed since,
            a setting that it does not have, or code that the user did not name (`require_named`).

    Example:
        >>> spec, wiring = load_robot("my_leg.toml")  # doctest: +SKIP
    """
    path = Path(path)
    document = robot_document(path)
    model, beside = document.model, path.parent / document.model.env
    env = os.path.normpath(beside) if beside.is_file() else model.env
    spec = EnvSpec.of_document(env, {**model.settings, **(settings or {})}, str(path))
    try:
        if spec.is_model:
            _ = spec.model_settings
        if model.sha256 and spec.file is not None:
            digest = code_of_file(spec.file)
            if digest != model.sha256:
                raise TegotaeError(
                    f"{model.env} has changed since this file was written; see whether the "
                    f'wiring fits, and accept the model by sha256 = "{digest}"'
                )
        wiring = wiring_of(document, path.parent)
        return spec.for_wiring(wiring), wiring
    except TegotaeError as error:
        raise TegotaeError(f"{path}: {error}") from None


def environment_named(
    env: str, settings: Iterable[str] = (), *, feet: Sequence[str] = ()
) -> EnvSpec:
    """Return the environment of a name, which may be a robot's file.

    Args:
        env: the name.
        settings: further settings, NAME=VALUE; of a robot's file those that differ.
        feet: bodies or geoms of a MuJoCo model that touch the ground, if they are named.

    Raises:
        TegotaeError: for a setting that is no NAME=VALUE, or a robot's file that is none.
    """
    feet_text = [f"feet={json.dumps([*feet])}"] if feet else []
    overrides = settings_of([*feet_text, *settings])
    if is_robot_file(env):
        return load_robot(env, overrides)[0]
    return EnvSpec(env=env, settings=tuple(overrides.items()))


def wired_environment(
    env: str, settings: Iterable[str] = (), *, wiring: str | None = None, scales: bool = False
) -> tuple[EnvSpec, Wiring]:
    """Return the environment of a name, and the wiring of its limbs.

    Args:
        env: the name.
        settings: further settings, NAME=VALUE.
        wiring: file of the wiring, if the environment does not come with one.
        scales: True to take scales that the wiring lacks from the MuJoCo model.

    Raises:
        TegotaeError: if there is no wiring, or something of it cannot be used.
    """
    spec, has_wiring = environment_named(env, settings), is_robot_file(env)
    if has_wiring and wiring is not None:
        raise TegotaeError(f"{env} has a wiring; leave --wiring out, or name its model")
    if wiring is None and not has_wiring and env not in packaged():
        spec.make().close()  # a name with a slip lacks more than a wiring
        first = f"; tegotae wiring suggest {env} writes a robot's file" if spec.is_model else ""
        raise TegotaeError(
            f"no wiring is given for {env}; write --wiring FILE.toml, which says what its limbs "
            f"sense and drive{first}"
        )
    loaded = load_wiring(env if wiring is None else wiring)
    spec = spec.for_wiring(loaded)
    if scales:
        environment = spec.make()
        loaded = loaded.with_scales(environment)
        environment.close()
    return spec, loaded


def save_robot(
    spec: EnvSpec, wiring: Wiring, path: Path | str, *, reasons: Mapping[str, str] | None = None
) -> None:
    """Write a robot's file, TOML.

    Args:
        spec: the environment, mostly a MuJoCo model.
        wiring: the wiring of its limbs, without controller and weights.
        path: its file.
        reasons: comments behind entries, as of `tegotae.envs.save_wiring`.

    Raises:
        TegotaeError: if it cannot be written.
    """
    path, file, env = Path(path), spec.file, spec.env
    if Path(env).is_file() and not os.path.isabs(env):
        env = Path(os.path.relpath(env, path.parent)).as_posix()
    model = {"env": env} if file is None else {"env": env, "sha256": code_of_file(file)}
    settings = {name: x for name, x in spec.settings if name != "feet"}  # contact_bodies are they
    document = {"model": model, "model.settings": settings, **wiring_document(wiring)}
    comments = {"model.sha256": "of the model's file", **(reasons or {})}
    write_atomically(path, toml_of({**document, "format": ROBOT_FORMAT}, comments))
