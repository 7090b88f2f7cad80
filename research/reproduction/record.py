"""The record of one unit: a file that is whole or is not there."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Document
from tegotae.study import CellResult
from tegotae.systems.experiment import Experiment

_PLAIN = ("weights", "deviation", "best_fitness", "generations", "ended", "omega")
"""Entries of a record that are arrays."""
_NAMED = {
    "curve_": "curves",
    "metric_": "episodes",
    "budget_": "at_budgets",
    "sampled_": "sampled",
    "gait_": "gait",
}
"""Entries that are arrays by name, by what their names begin with in a file."""


@dataclass(frozen=True)
class Record:
    """Results of a unit of the study.

    Args:
        configuration: all that decides the content (`Unit.configuration`).
        software: versions of the programs that made it, and the engine.
        weights: the learned weights, shape [runs, n_weights]: the mean of the best distribution
            that a run saw.
        deviation: the standard deviation of that distribution, shape [runs, n_weights]; zero of a
            search.
        best_fitness: fitness of the best distribution seen, shape [runs].
        generations: of each run, shape [runs].
        ended: why each run ended: "plateau", "cap" or "search", shape [runs].
        curves: learning curves by name, each of shape [generations, runs]; NaN after a run's end.
        omega: frequencies of the evaluated episodes [rad/s], shape [episodes].
        episodes: metrics by name, each of shape [runs, episodes]; NaN where undefined.
        at_budgets: the same after some budgets of training (the configuration's `budgets`), each of
            shape [budgets, runs, episodes]; empty for what is not trained.
        sampled: the same for a controller drawn from each run's distribution, shape
            [runs, episodes].
        gait: channels of the best run's gait, each of shape [frames] (`best_gait.gait_channels`).
    """

    configuration: Document
    software: dict[str, str]
    weights: np.ndarray
    deviation: np.ndarray
    best_fitness: np.ndarray
    generations: np.ndarray
    ended: np.ndarray
    curves: dict[str, np.ndarray]
    omega: np.ndarray
    episodes: dict[str, np.ndarray]
    at_budgets: dict[str, np.ndarray]
    sampled: dict[str, np.ndarray]
    gait: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def model(self) -> str:
        """Name of the experiment, which for the paper's is that of the model."""
        return self.configuration["experiment"]["name"]

    @property
    def engine(self) -> str:
        """The engine that made it (`tegotae._support.engines`)."""
        return self.software["engine"]

    @property
    def experiment(self) -> Experiment:
        """Experiment that was trained and evaluated.

        Raises:
            TegotaeError: if it has a part that is not registered.
        """
        return Experiment.from_document(self.configuration["experiment"])

    @property
    def result(self) -> CellResult:
        """The record as a file holds it."""
        arrays = {name: getattr(self, name) for name in _PLAIN}
        for prefix, name in _NAMED.items():
            arrays |= {f"{prefix}{key}": values for key, values in getattr(self, name).items()}
        return CellResult(self.configuration, self.software, arrays)

    @property
    def population(self) -> int:
        """Episodes of training per generation."""
        return self.configuration["algorithm"]["population"]

    @property
    def budgets(self) -> list[int]:
        """After how many episodes of training it was evaluated, too."""
        return self.configuration["budgets"]


def read_record(path: Path) -> Record:
    """Read a record.

    Raises:
        DamagedDocumentError: if it is no record, is cut short, or its checksum is wrong.
        TegotaeError: if it cannot be opened, such as without permission.
    """
    result = CellResult.read(path)
    try:
        return record_of(result)
    except Exception as error:  # whatever a file may hold
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise DamagedDocumentError(f"{path.name} is damaged: {reason}") from None


def record_of(result: CellResult) -> Record:
    """Return the record in a result.

    Raises:
        ValueError: if the result is that of no unit of a study.
    """
    header = {"configuration": result.document, "software": result.software}
    documents.fitted(header, _Header)
    entries: dict[str, Any] = {name: result.arrays[name] for name in _PLAIN}
    entries |= {name: _with_prefix(result.arrays, prefix) for prefix, name in _NAMED.items()}
    record = Record(result.document, result.software, **entries)
    _require_shapes(record)
    return record


class _RecordedAlgorithm(msgspec.Struct):
    population: Annotated[int, msgspec.Meta(ge=1)]


class _RecordedExperiment(msgspec.Struct):
    name: str


class _RecordedConfiguration(msgspec.Struct):
    """Checked entries of a record's configuration; the whole configuration determines the
    record's name.
    """

    experiment: _RecordedExperiment
    algorithm: _RecordedAlgorithm
    budgets: list[Annotated[int, msgspec.Meta(ge=1)]]


class _Header(msgspec.Struct):
    configuration: _RecordedConfiguration
    software: dict[str, str]


def _require_shapes(record: Record) -> None:
    """Check that the arrays are of one set of runs and episodes, and of the right kind.

    Raises:
        ValueError: if not.
    """
    runs, episodes = len(record.best_fitness), len(record.omega)
    generations = len(next(iter(record.curves.values()), []))
    frames = len(next(iter(record.gait.values()), []))
    weights = (runs, record.weights.shape[-1] if record.weights.ndim else 0)
    expected = {
        "weights": ("f", weights),
        "deviation": ("f", weights),
        "best_fitness": ("f", (runs,)),
        "generations": ("i", (runs,)),
        "ended": ("U", (runs,)),
        "omega": ("f", (episodes,)),
        "curves": ("f", (generations, runs)),
        "episodes": ("f", (runs, episodes)),
        "sampled": ("f", (runs, episodes)),
        "at_budgets": ("f", (len(record.budgets), runs, episodes)),
        "gait": ("f", (frames,)),
    }
    if runs == 0:
        raise ValueError("it has no runs")
    for name, (kind, shape) in expected.items():
        entry = getattr(record, name)
        for key, values in entry.items() if isinstance(entry, dict) else [("", entry)]:
            if values.dtype.kind != kind or values.shape != shape:
                raise ValueError(
                    f"its {key or name} has {values.dtype} values of shape {values.shape}, "
                    f"where {shape} belong"
                )


def _with_prefix(arrays: dict[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {
        name.removeprefix(prefix): values
        for name, values in arrays.items()
        if name.startswith(prefix)
    }
