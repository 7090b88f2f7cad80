"""The study's results as one table: a row per model and run."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tegotae.bodies import Hopper
from tegotae.errors import TegotaeError
from tegotae.metrics.metric import Conditions
from tegotae.metrics.registry import derived, names
from tegotae.metrics.statistics import mean_defined
from tegotae.models import Model, all_models, find
from tegotae.study.record import Record


_DESIGN = (
    *("model", "architecture", "learned", "reaction", "gain", "actuation", "observation"),
    *("omega_t", "run"),
)
_TRAINING = ("best_fitness", "episodes_trained", "ended", "training_budget")


@dataclass(frozen=True)
class Table:
    """Columns of equal length. Metrics are means over a run's episodes, NaN where undefined.

    Args:
        columns: by name: `model`, `architecture`, `learned`, `reaction`, `gain`, `actuation`,
            `observation`, `omega_t` [rad/s], `run`, `best_fitness`, `episodes_trained`, `ended`,
            and the metrics that it holds; in a table of budgets also `training_budget` [episodes].
    """

    columns: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["model"])

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self.columns[name]
        except KeyError:
            raise TegotaeError(f"the table has no column {name}") from None

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metrics that it holds: those with a column in which anything is defined."""
        return tuple(
            name
            for name, column in self.columns.items()
            if name not in (*_DESIGN, *_TRAINING) and not np.isnan(column).all()
        )

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
    return of_runs(
        (record.model, _training(record), _means(record, record.episodes))
        for record in _ordered(records)
    )


def tabulate_budgets(records: Iterable[Record]) -> Table | None:
    """The same after each budget of training, in the column `training_budget`; None without any.

    What is not trained is the same after each.
    """
    rows = []
    for record in _ordered(records):
        for i, budget in enumerate(record.budgets):
            training = _training(record)
            episodes = np.minimum(training.pop("episodes_trained"), budget)
            training |= {"training_budget": np.full(len(episodes), budget)}
            training |= {"episodes_trained": episodes, "best_fitness": _best(record, budget)}
            metrics = {name: values[i] for name, values in record.at_budgets.items()}
            rows.append((record.model, training, _means(record, metrics or record.episodes)))
    return of_runs(rows) if rows else None


def _ordered(records: Iterable[Record]) -> list[Record]:
    by_model = {record.model: record for record in records}
    return [by_model[name] for name in all_models() if name in by_model]


def _means(record: Record, episodes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Means over the episodes of each run, of what was measured and of what follows from it.

    What follows is found episode by episode: it would be another thing of means.
    """
    protocol = record.configuration["protocol"]
    body = Hopper(**record.configuration["hopper"])
    conditions = Conditions(body, protocol["work"], protocol["drop_m"])
    whole = episodes | derived(episodes, conditions)
    return {name: mean_defined(values) for name, values in whole.items()}


def _training(record: Record) -> dict[str, np.ndarray]:
    """How each run's training went, [runs] each."""
    return {
        "best_fitness": record.best_fitness,
        "episodes_trained": record.generations * record.population,
        "ended": record.ended,
    }


def _best(record: Record, budget: int) -> np.ndarray:
    """Best fitness of the distribution's mean within a budget of episodes, [runs]."""
    if not record.curves:
        return record.best_fitness
    generations = math.ceil(budget / record.population)
    return np.nanmax(record.curves["centre_fitness"][:generations], axis=0)


def of_runs(sets: Iterable[tuple[str, dict[str, np.ndarray], dict[str, np.ndarray]]]) -> Table:
    """The table of (model's name, training of its runs, metrics of its runs), [runs] each.

    It has the metrics of any of them, in the order in which metrics are shown; a metric that a
    model lacks is undefined there.
    """
    sets = list(sets)
    found = {metric for _, _, metrics in sets for metric in metrics}
    held = [*(name for name in names() if name in found), *sorted(found.difference(names()))]
    rows: dict[str, list] = {}
    for name, training, metrics in sets:
        place = design(find(name))
        for i in range(len(training["best_fitness"])):
            row = {
                **place,
                "run": i,
                **{key: values[i].item() for key, values in training.items()},
                **{m: float(metrics[m][i]) if m in metrics else np.nan for m in held},
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
