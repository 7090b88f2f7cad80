"""A policy by the name of its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tegotae._support.errors import TegotaeError
from tegotae.envs.policies.base import Meaning, Policy
from tegotae.envs.policies.function import from_function
from tegotae.envs.policies.onnx import from_onnx
from tegotae.envs.policies.sb3 import from_sb3
from tegotae.systems.user_objects import is_reference, named


def load_policy(place: str, meaning: Meaning | None = None) -> Policy:
    """The policy of a .zip of Stable-Baselines3, an .onnx file, or a function of your own file.

    Args:
        place: a path, or `FILE.py:OBJECT` or `MODULE:OBJECT`, of a function or a `Policy`.
        meaning: what it observes and does; a `Policy` has its own.

    Raises:
        TegotaeError: for another ending, or what the kind of file refuses.
    """
    ending = Path(place).suffix.lower()
    if ending == ".zip":
        return from_sb3(place, meaning)
    if ending == ".onnx":
        return from_onnx(place, meaning)
    if not is_reference(place):
        raise TegotaeError(
            f"{place} is no policy: write a .zip of Stable-Baselines3, an .onnx file, or "
            "FILE.py:FUNCTION"
        )
    found = named(place, object, "policy")
    if isinstance(found, Policy):
        return found
    if not callable(found):
        raise TegotaeError(f"{place} is no policy: a {type(found).__name__} cannot be called")
    return replace(from_function(found, meaning), name=place.rpartition(":")[2])
