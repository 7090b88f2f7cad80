"""A policy from a file, by its name: ONNX, Stable-Baselines3, a function."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs.policies.base import Meaning, Policy, check_entries, from_function
from tegotae.envs.policies.sb3 import from_sb3
from tegotae.systems.user_objects import is_reference, named


def from_onnx(path: Path | str, meaning: Meaning | None = None) -> Policy:
    """A network with one input [n, entries] of float32, whose first output is the answer, [n, 1].

    Args:
        path: the .onnx file.
        meaning: what it observes and does; what the environment tegotae/Hopper-v0 means by default.

    Raises:
        TegotaeError: for a file that is no such network, or one that observes another number of
            numbers.
        MissingExtraError: without onnxruntime (extra "onnx").
    """
    path, meaning = Path(path), Meaning() if meaning is None else meaning
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    runtime = require("onnxruntime", "onnx")
    try:
        session = runtime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's own, which share no base
        first = (str(error).splitlines() or [""])[0]
        raise TegotaeError(f"{path} is no ONNX network: {first}") from None
    inputs = session.get_inputs()
    if len(inputs) != 1 or len(inputs[0].shape) != 2:
        shapes = ", ".join(f"{each.name} {each.shape}" for each in inputs)
        raise TegotaeError(f"{path} takes {shapes}; it must take one input of shape [n, entries]")
    batch, entries = inputs[0].shape
    check_entries(str(path), entries if isinstance(entries, int) else None, meaning)
    name = inputs[0].name

    def answer(observed: np.ndarray) -> np.ndarray:
        rows = observed.astype(np.float32)
        if isinstance(batch, int) and batch == 1:  # exported for one observation at a time
            return np.array([session.run(None, {name: row[None]})[0].ravel()[0] for row in rows])
        return session.run(None, {name: rows})[0]

    return Policy(answer, meaning, path.stem)


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
