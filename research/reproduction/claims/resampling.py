"""Values of models, and the same with their runs resampled: the bootstrap behind intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from research.reproduction.claims.counting import BEST, MEAN, SAMPLED, Count, metric_per_run
from research.reproduction.table import StudyTable
from tegotae.measures.statistics import mean_defined

RESAMPLES = 2000
"""Number of bootstrap samples of the runs of every model."""


@dataclass(frozen=True)
class ModelColumns:
    """Columns of each model, [models], in the order of the table."""

    name: np.ndarray
    architecture: np.ndarray
    observation: np.ndarray
    actuation: np.ndarray
    omega_t: np.ndarray


class Resampled:
    """A study's table with its runs resampled, the same draws for all metrics and counts.

    Args:
        table: the study's runs, or their episodes.
        resamples: how often.
        seed: of the draws.
    """

    def __init__(self, table: StudyTable, resamples: int = RESAMPLES, seed: int = 0) -> None:
        self.table = table
        self._random = np.random.default_rng(seed)
        self._resamples = resamples
        self._draws: dict[tuple[str, int], np.ndarray] = {}
        self._known: dict[tuple[str, str, str], np.ndarray] = {}
        _, first = np.unique(table["model"], return_index=True)
        first = np.sort(first)
        columns = ("model", "architecture", "observation", "actuation", "omega_t")
        name, architecture, observation, actuation, omega_t = (table[c][first] for c in columns)
        self.models = ModelColumns(name, architecture, observation, actuation, omega_t)

    def values(self, metric: str, count: Count) -> np.ndarray:
        """Return a metric of every model, [1 + resamples, models]: as it is, and in each draw of
        the runs.

        NaN where undefined. The mean of runs needs two that define it, unless there is one only.
        """
        key = metric, count.unsettled, count.run
        if key not in self._known:
            rows = metric_per_run(self.table, metric, count.unsettled)
            sample = rows.columns.get("sample", np.zeros(len(rows)))
            of_model = {str(name): rows["model"] == name for name in self.models.name}
            columns = [
                self._model_values(str(name), rows, metric, sample, of_model[str(name)], count.run)
                for name in self.models.name
            ]
            self._known[key] = np.stack(columns, axis=1)
        return self._known[key]

    def _model_values(
        self,
        name: str,
        rows: StudyTable,
        metric: str,
        sample: np.ndarray,
        mask: np.ndarray,
        run: str,
    ) -> np.ndarray:
        centre = mask & (sample == 0)
        values, fitness = rows[metric][centre], rows["best_fitness"][centre]
        drawn = self._drawn(name, len(values))
        if run == MEAN:
            if len(values) > 1 and np.isfinite(values).sum() < 2:
                return np.full(1 + self._resamples, np.nan)
            return mean_defined(values[drawn])
        best = fitness[drawn]
        is_best = best == best.max(axis=1, keepdims=True)
        if run == BEST:
            return mean_defined(np.where(is_best, values[drawn], np.nan))
        assert run == SAMPLED
        runs = rows["run"][centre][drawn[np.arange(len(drawn)), is_best.argmax(axis=1)]]
        return self._sampled(
            rows["run"][mask & (sample > 0)], rows[metric][mask & (sample > 0)], runs
        )

    def _sampled(self, of_run: np.ndarray, values: np.ndarray, runs: np.ndarray) -> np.ndarray:
        """Draw one controller from each of some runs' distributions; the first is their mean."""
        drawn = np.full(len(runs), np.nan)
        for run in np.unique(runs):
            of_it = values[of_run == run]
            mask = runs == run
            if len(of_it):
                drawn[mask] = self._random.choice(of_it, mask.sum())
        drawn[0] = mean_defined(values[of_run == runs[0]][None])[0]
        return drawn

    def _drawn(self, name: str, runs: int) -> np.ndarray:
        """Return the numbers of a model's runs, [1 + resamples, runs]; the first row has each
        of them once.
        """
        if (name, runs) not in self._draws:
            anew = self._random.integers(0, runs, (self._resamples, runs))
            self._draws[name, runs] = np.concatenate([np.arange(runs)[None], anew])
        return self._draws[name, runs]
