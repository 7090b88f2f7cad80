"""The record of one unit: a file that is whole or is not there."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tegotae.errors import TegotaeError
from tegotae.experiment import Experiment
from tegotae.files import write_atomically

SUFFIX = ".record.npz"

_PLAIN = ("weights", "best_fitness", "generations", "ended", "omega")
"""Entries of a record that are arrays."""
_NAMED = {"curve_": "curves", "metric_": "episodes", "budget_": "at_budgets"}
"""Entries that are arrays by name, by what their names begin with in a file."""


class DamagedRecordError(TegotaeError):
    """A record that cannot be read, or does not hold what it says."""


@dataclass(frozen=True)
class Record:
    """What a unit of the study found.

    Args:
        configuration: all that decides the content (`Unit.configuration`).
        software: versions of the programs that made it, and on which devices.
        weights: the learned weights, shape [runs, n_weights].
        best_fitness: fitness of the best distribution seen, shape [runs].
        generations: of each run, shape [runs].
        ended: why each run ended: "plateau", "cap" or "search", shape [runs].
        curves: learning curves by name, each of shape [generations, runs]; NaN after a run's end.
        omega: frequencies of the evaluated episodes [rad/s], shape [episodes].
        episodes: metrics by name, each of shape [runs, episodes]; NaN where undefined.
        at_budgets: the same after some budgets of training (the configuration's `budgets`), each of
            shape [budgets, runs, episodes]; empty for what is not trained.
    """

    configuration: dict[str, Any]
    software: dict[str, str]
    weights: np.ndarray
    best_fitness: np.ndarray
    generations: np.ndarray
    ended: np.ndarray
    curves: dict[str, np.ndarray]
    omega: np.ndarray
    episodes: dict[str, np.ndarray]
    at_budgets: dict[str, np.ndarray]

    @property
    def model(self) -> str:
        """The experiment's name: the model's, for the paper's."""
        return self.configuration["experiment"]["name"]

    @property
    def experiment(self) -> Experiment:
        """What was trained and evaluated.

        Raises:
            TegotaeError: if it has a part that is not registered.
        """
        return Experiment.of(self.configuration["experiment"])

    @property
    def population(self) -> int:
        """Episodes of training per generation."""
        return self.configuration["algorithm"]["population"]

    @property
    def budgets(self) -> list[int]:
        """After how many episodes of training it was evaluated, too."""
        return self.configuration["budgets"]


def write(record: Record, path: Path) -> None:
    """Write a record, with a checksum over its content.

    Raises:
        TegotaeError: if it cannot be written, such as for want of space.
    """
    arrays = {name: getattr(record, name) for name in _PLAIN}
    for prefix, name in _NAMED.items():
        arrays |= {f"{prefix}{key}": values for key, values in getattr(record, name).items()}
    header = {"configuration": record.configuration, "software": record.software}
    text = json.dumps(header, sort_keys=True)
    stream = io.BytesIO()
    np.savez_compressed(
        stream,
        allow_pickle=False,
        header=np.array(text),
        checksum=np.array(_checksum(text, arrays)),
        **arrays,
    )
    write_atomically(path, stream.getvalue())


def read(path: Path) -> Record:
    """Read a record.

    Raises:
        DamagedRecordError: if it is no record, is cut short, or its checksum is wrong.
        TegotaeError: if it cannot be opened, such as for want of permission.
    """
    try:
        stream = path.open("rb")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    try:
        with stream, np.load(stream, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        text, checksum = str(arrays.pop("header")), str(arrays.pop("checksum"))
        if checksum != _checksum(text, arrays):
            raise ValueError("its checksum is wrong")
        header = json.loads(text)
        plain: dict[str, Any] = {name: arrays[name] for name in _PLAIN}
        named: dict[str, Any] = {
            name: _with_prefix(arrays, prefix) for prefix, name in _NAMED.items()
        }
        return Record(
            header["configuration"],
            header["software"],
            **plain,
            **named,
        )
    except Exception as error:  # a flipped bit in a zip archive may raise nearly anything
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise DamagedRecordError(f"{path.name} is damaged: {why}") from None


def _with_prefix(arrays: dict[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {
        name.removeprefix(prefix): values
        for name, values in arrays.items()
        if name.startswith(prefix)
    }


def _checksum(header: str, arrays: dict[str, np.ndarray]) -> str:
    digest = hashlib.sha256(header.encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {values.dtype.str} {values.shape}".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()
