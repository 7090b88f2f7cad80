"""The study's results as one table: a row per model and run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tegotae.evaluation import METRICS
from tegotae.metrics.statistics import mean_defined
from tegotae.models import Model, all_models, find
from tegotae.study.record import Record


@dataclass(frozen=True)
class Table:
    """Columns of equal length. Metrics are means over a run's episodes, NaN where undefined.

    Args:
        columns: by name: `model`, `architecture`, `learned`, `reaction`, `gain`, `actuation`,
            `observation`, `omega_t` [rad/s], `run`, `best_fitness`, and every one of `METRICS`.
    """

    columns: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["model"])

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def where(self, **values: Any) -> Table:
        """The rows in which each named column has the given value, or one of a tuple of values."""
        keep = np.ones(len(self), bool)
        for name, value in values.items():
            allowed = value if isinstance(value, tuple) else (value,)
            keep &= np.isin(self.columns[name], allowed)
        return Table({name: column[keep] for name, column in self.columns.items()})

    def per_model(self) -> Table:
        """One row a model: means over its runs of what is defined."""
        names, first = np.unique(self.columns["model"], return_index=True)
        order = np.argsort(first)
        names, first = names[order], first[order]
        columns = {}
        for name, column in self.columns.items():
            if column.dtype.kind == "f":
                groups = [column[self.columns["model"] == model] for model in names]
                columns[name] = np.array([float(mean_defined(group)) for group in groups])
            else:
                columns[name] = column[first]
        return Table(columns)


def tabulate(records: Iterable[Record]) -> Table:
    """The table of some records, in the order of the registry of models."""
    by_model = {record.model: record for record in records}
    known = [by_model[name] for name in all_models() if name in by_model]
    return of_runs(
        (
            record.model,
            record.best_fitness,
            {m: mean_defined(values) for m, values in record.episodes.items()},
        )
        for record in known
    )


def of_runs(sets: Iterable[tuple[str, np.ndarray, dict[str, np.ndarray]]]) -> Table:
    """The table of (model's name, fitness of its runs [runs], metrics of its runs [runs] each)."""
    rows: dict[str, list] = {}
    for name, fitness, metrics in sets:
        place = design(find(name))
        for i, value in enumerate(fitness):
            row = {
                **place,
                "run": i,
                "best_fitness": float(value),
                **{m: float(metrics[m][i]) if m in metrics else np.nan for m in METRICS},
            }
            for key, entry in row.items():
                rows.setdefault(key, []).append(entry)
    return Table({key: np.array(values) for key, values in rows.items()})


def design(model: Model) -> dict[str, Any]:
    """Where a model stands in the study's design."""
    return {
        "model": model.name,
        "architecture": model.architecture,
        "learned": "".join(model.learned_terms),
        "reaction": model.reaction or "",
        "gain": model.gain or "",
        "actuation": model.actuation_name,
        "observation": "Fv" if "velocity" in model.observation else "F",
        "omega_t": np.nan if model.omega_t is None else model.omega_t,
    }
