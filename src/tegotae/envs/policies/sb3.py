"""A model of Stable-Baselines3, its .zip, as a policy."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.optional_dependencies import require
from tegotae.envs.policies.base import Meaning, Policy, check_entries


def from_sb3(path: Path | str, meaning: Meaning | None = None) -> Policy:
    """The deterministic policy of a model of SAC, PPO, TD3, DDPG or A2C.

    A model's file can run programs as it is loaded: load only what you trust.

    Args:
        path: the .zip that the model's `save` wrote.
        meaning: what it observes and does; what the environment tegotae/Hopper-v0 means by default.

    Raises:
        TegotaeError: for a file that is no model, or one that observes another number of numbers.
        MissingExtraError: without Stable-Baselines3.
    """
    path, meaning = Path(path), Meaning() if meaning is None else meaning
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    algorithm = _algorithm(path)
    sb3 = require("stable_baselines3", "sb3")
    try:
        # What training alone needs may not be readable by another version.
        unused = {"learning_rate": 0.0, "lr_schedule": lambda _: 0.0, "clip_range": lambda _: 0.0}
        model: Any = getattr(sb3, algorithm).load(path, device="cpu", custom_objects=unused)
    except Exception as error:  # of torch, pickle or a version too old
        first = (str(error).splitlines() or [""])[0]
        raise TegotaeError(f"{path} cannot be loaded as {algorithm}: {first}") from None
    shape = getattr(model.observation_space, "shape", None)
    if not shape or len(shape) != 1:
        raise TegotaeError(f"{path} observes {model.observation_space}; it must be one row of Box")
    check_entries(str(path), shape[0], meaning)

    def answer(observed: np.ndarray) -> np.ndarray:
        return model.predict(observed.astype(np.float32), deterministic=True)[0]

    return Policy(answer, meaning, path.stem)


def _algorithm(path: Path) -> str:
    """Which algorithm's model a file holds, read from the place of its policy's class."""
    try:
        with zipfile.ZipFile(path) as archive:
            data = json.loads(archive.read("data"))
        module = data["policy_class"]["__module__"]
    except Exception:  # a flipped bit in a zip archive may raise nearly anything
        raise TegotaeError(f"{path} is no model of Stable-Baselines3") from None
    name = module.split(".")[1].upper() if module.startswith("stable_baselines3.") else module
    if name == "COMMON":  # the policies of those that have none of their own
        name = "PPO" if "clip_range" in data else "A2C"
    if name == "TD3" and data.get("policy_delay") == 1:
        name = "DDPG"
    if name not in ("SAC", "PPO", "TD3", "DDPG", "A2C"):
        raise TegotaeError(f"{path} holds a policy of {name}; known are SAC, PPO, TD3, DDPG, A2C")
    return name
