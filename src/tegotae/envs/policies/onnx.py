"""An ONNX file as a policy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs.policies.base import Meaning, Policy, check_entries


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
