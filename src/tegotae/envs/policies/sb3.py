"""A model of Stable-Baselines3, its .zip, as a policy."""

from __future__ import annotations

import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs.policies.base import Meaning, Policy, check_entries

_OF_TRAINING = ("optimizer_class", "optimizer_kwargs")
"""Settings of a policy that its answers do not depend on."""


def from_sb3(path: Path | str, meaning: Meaning | None = None) -> Policy:
    """The deterministic policy of a model of SAC, PPO, TD3, DDPG or A2C.

    Only its numbers are read: a model's file has pickled parts, too, which could run code.

    Args:
        path: the .zip that the model's `save` wrote.
        meaning: what it observes and does; what the environment tegotae/Hopper-v0 means by default.

    Raises:
        TegotaeError: for a file that is no model, one that observes another number of numbers, or
            one whose policy has parts of its author's.
        MissingExtraError: without Stable-Baselines3.
    """
    path, meaning = Path(path), Meaning() if meaning is None else meaning
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    document = _document(path)
    algorithm = _algorithm(path, document)
    sb3 = require("stable_baselines3", "sb3")
    try:
        policy = _policy(path, document, getattr(sb3, algorithm))
    except TegotaeError:
        raise
    except Exception as error:  # of torch, or of a file of another version
        first = (str(error).splitlines() or [""])[0]
        raise TegotaeError(f"{path} cannot be loaded as {algorithm}: {first}") from None
    check_entries(str(path), policy.observation_space.shape[0], meaning)

    def answer(observed: np.ndarray) -> np.ndarray:
        return policy.predict(observed.astype(np.float32), deterministic=True)[0]

    return Policy(answer, meaning, path.stem)


def _document(path: Path) -> Any:
    """What a model's file says in JSON."""
    try:
        with zipfile.ZipFile(path) as archive:
            document = json.loads(archive.read("data"))
        document["policy_class"]["__module__"].split(".")
    except Exception:  # a flipped bit in a zip archive may raise nearly anything
        raise TegotaeError(f"{path} is no model of Stable-Baselines3") from None
    return document


def _algorithm(path: Path, document: Any) -> str:
    """Which algorithm's model a file holds, by the place of its policy's class."""
    module = document["policy_class"]["__module__"]
    name = module.split(".")[1].upper() if module.startswith("stable_baselines3.") else module
    if name == "COMMON":  # the policies of those that have none of their own
        name = "PPO" if "clip_range" in document else "A2C"
    if name == "TD3" and document.get("policy_delay") == 1:
        name = "DDPG"
    if name not in ("SAC", "PPO", "TD3", "DDPG", "A2C"):
        raise TegotaeError(f"{path} holds a policy of {name}; known are SAC, PPO, TD3, DDPG, A2C")
    return name


def _policy(path: Path, document: Any, algorithm: Any) -> Any:
    """The usual policy of an algorithm with the weights of a file."""
    import torch

    settings = _settings(path, document["policy_kwargs"])
    if algorithm.__name__ in ("PPO", "A2C"):  # the others have it among these
        settings["use_sde"] = document["use_sde"]
    policy = algorithm.policy_aliases["MlpPolicy"](
        _box(path, "observes", document["observation_space"]),
        _box(path, "acts by", document["action_space"]),
        lambda _: 0.0,
        **settings,
    )
    with zipfile.ZipFile(path) as archive:
        weights = io.BytesIO(archive.read("policy.pth"))
    policy.load_state_dict(torch.load(weights, map_location="cpu", weights_only=True))
    return policy


def _settings(path: Path, written: dict[str, Any]) -> dict[str, Any]:
    """Settings of a policy: plain values, and the activation by its name."""
    from torch import nn

    settings = {}
    for name, value in written.items():
        if name.startswith(":") or name in _OF_TRAINING:
            continue
        if isinstance(value, str):  # of an object, which is also there as a pickle
            known = re.fullmatch(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>", value)
            if known is None:
                raise TegotaeError(
                    f"{path} has a policy with {name} {value}, which only code within the file "
                    "can restore; load the model in a function of your own, FILE.py:FUNCTION"
                )
            value = getattr(nn, known[1])
        settings[name] = value
    return settings


def _box(path: Path, does: str, written: dict[str, Any]) -> Any:
    """A space, by the text of its limits."""
    from gymnasium.spaces import Box

    kind = written.get(":type:", "")
    if not kind.endswith("spaces.box.Box'>") or len(written["_shape"]) != 1:
        raise TegotaeError(
            f"{path} {does} {kind} of shape {written.get('_shape')}; it must be one row of Box"
        )
    low, high = (
        np.array(written[name].strip("[]").split(), np.float32) for name in ("low", "high")
    )
    return Box(low, high)
