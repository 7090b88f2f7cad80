"""Evaluations: measurements of runs, their means with intervals, and the differences of two."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError
from tegotae.api.results import MatplotlibFigure, Table, short
from tegotae.measures import statistics
from tegotae.measures.metric import TABLE, Metric
from tegotae.measures.statistics import Interval


@dataclass(frozen=True, repr=False, kw_only=True)
class EvaluationTable(Table):
    """Measurements of runs, and their means."""

    rows: pd.DataFrame = field(default_factory=pd.DataFrame)
    """Rows named by `controller`, `run` and more, such as the frequency or the start."""
    metrics: tuple[Metric, ...]
    """Measured quantities."""
    shows_all: bool = False
    """True if the screen shows all metrics, and not the usual ones alone; files have all."""
    groups: tuple[str, ...] = ("controller",)
    """Columns that name a row of the summary. Runs are independent; the mean of a run over all
    else, such as starts, is taken first."""
    trained: Mapping[str, Hashable] = field(default_factory=dict)
    """Facts that decide what the training of each controller drew, None if they are not known:
    where they are equal, runs are paired."""
    exact: frozenset[str] = frozenset()
    """Controllers that a search found, from which no other run would differ."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Options of each controller."""
    base: str = ""
    """Controller that others are compared with, if any."""

    @classmethod
    def joined(cls, tables: Sequence[EvaluationTable]) -> EvaluationTable:
        """Return one table of several that measure the same."""
        return dataclasses.replace(
            tables[0],
            rows=pd.concat([table.rows for table in tables], ignore_index=True),
            notes=tuple(dict.fromkeys(note for table in tables for note in table.notes)),
            metrics=tuple({x.name: x for table in tables for x in table.metrics}.values()),
            trained={name: x for table in tables for name, x in table.trained.items()},
            exact=frozenset[str]().union(*(table.exact for table in tables)),
            settings={name: x for table in tables for name, x in table.settings.items()},
        )

    def summary(self) -> pd.DataFrame:
        """Return the mean of each column over runs with its interval, or the commonest texts."""
        groups = self._grouped()
        cells = {x.name: [_mean(x, rows) for rows in groups.values()] for x in self.metrics}
        runs = [rows["run"].nunique() for rows in groups.values()]
        return self._indexed(list(groups), {"runs": runs, **cells})

    def differences(self) -> pd.DataFrame:
        """Return each controller minus the base at equal other groups, run by run where paired.

        Raises:
            TegotaeError: if nothing can be compared with the base.
        """
        groups = self._grouped()
        pairs = {
            key: (rows, groups[self.base, *key[1:]])
            for key, rows in groups.items()
            if key[0] != self.base and (self.base, *key[1:]) in groups
        }
        if not pairs:
            raise TegotaeError(f"nothing compares with {self.base}: no frequency is the same")
        methods = [self._compared_as(key[0], rows) for key, (rows, _) in pairs.items()]
        cells = {
            x.name: [
                _difference(x, *p, kind) for p, kind in zip(pairs.values(), methods, strict=True)
            ]
            for x in self._numeric(self.metrics)
        }
        return self._indexed(list(pairs), {"runs": methods, **cells})

    def texts(self) -> list[pd.DataFrame]:
        tables = [self._texts(self.summary(), better=False)]
        if self.base:
            differences = self._texts(self.differences(), better=True)
            tables.append(differences.rename_axis(index={"controller": f"minus {self.base}"}))
        return tables

    def compared_with(self, base: str) -> EvaluationTable:
        """Return the same with the differences to one controller.

        Args:
            base: its name.
        """
        notes = [*self.notes, *COMPARED, *([EXACTLY] if self.exact else [])]
        return dataclasses.replace(self, base=base, notes=notes)

    def to_dict(self) -> JsonObject:
        document = {"settings": self.settings, "rows": self.rows.to_dict("records")}
        document["summary"] = self.summary().reset_index().to_dict("records")
        if self.base:
            rows = self.differences().reset_index().assign(minus=self.base)
            document["differences"] = rows.to_dict("records")
        return as_json(document)

    def figures(self) -> Mapping[str, MatplotlibFigure]:
        from tegotae.figures.intervals import intervals_figure

        frame, visible = self.summary(), self._numeric(self._visible())
        names = [", ".join(map(short, key)) for key in frame.index]
        return {"intervals": intervals_figure(names, {x.heading: frame[x.name] for x in visible})}

    def _visible(self) -> list[Metric]:
        """Return the metrics that the screen shows."""
        return [x for x in self.metrics if self.shows_all or TABLE in x.shown]

    def _numeric(self, metrics: Sequence[Metric]) -> list[Metric]:
        """Return the metrics whose values are numbers."""
        return [x for x in metrics if self.rows[x.name].dtype.kind in "fi"]

    def _grouped(self) -> dict[tuple[Any, ...], pd.DataFrame]:
        rows = self.rows.groupby(list(self.groups), sort=False, dropna=False)
        return {tuple(None if pd.isna(x) else x for x in key): part for key, part in rows}  # type: ignore[attr-defined]

    def _indexed(self, keys: list[tuple[Any, ...]], cells: Mapping[str, Any]) -> pd.DataFrame:
        index = pd.MultiIndex.from_tuples(keys, names=self.groups)
        return pd.DataFrame({name: pd.Series(x, index, object) for name, x in cells.items()})

    def _compared_as(self, name: str, rows: pd.DataFrame) -> str:
        ours, theirs = self.trained.get(name), self.trained.get(self.base)
        if ours is not None and ours == theirs and len(rows["run"].unique()) > 1:
            return PAIRED
        return EXACT if {name, self.base} & self.exact else INDEPENDENT

    def _texts(self, frame: pd.DataFrame, *, better: bool) -> pd.DataFrame:
        visible = [x for x in self._visible() if x.name in frame]
        cells = {x.heading: [_cell(x, cell, better) for cell in frame[x.name]] for x in visible}
        labels = [str(runs) for runs in frame["runs"]]
        if better:
            methods = frame[[x.name for x in visible]].map(lambda cell: cell.method)
            used_methods = [
                " and ".join(dict.fromkeys(filter(None, row))) for row in methods.to_numpy()
            ]
            labels = [
                f"{runs}, {row or 'no interval'}"
                for runs, row in zip(labels, used_methods, strict=True)
            ]
        keys = [frame.index.get_level_values(name).map(short) for name in frame.index.names]
        all_cells = {"interval" if better else "runs": labels, **cells}
        return pd.DataFrame(
            all_cells, index=pd.MultiIndex.from_arrays(keys, names=frame.index.names)
        )


PAIRED, INDEPENDENT, EXACT = "paired runs", "independent runs", "one run is exact"
"""Relations of two sets of runs that are compared."""
COMPARED = [
    "+ is better and - is worse, where the interval of the difference leaves zero out.",
    "Runs are paired, seed by seed, where they share what is random: controller, algorithm and "
    "conditions.",
]
EXACTLY = (
    "A gain that a search found is exact: no other run would differ. Against it the interval is "
    "that of the other runs alone; between two exact ones there is none."
)


def _run_values(metric: Metric, rows: pd.DataFrame) -> np.ndarray:
    """Return the mean of every run over its rows, [runs]."""
    runs = [run.to_numpy(float)[None] for _, run in rows.groupby("run", sort=False)[metric.name]]
    return np.array([statistics.mean_defined(values)[0] for values in runs])


def _mean(metric: Metric, rows: pd.DataFrame) -> Interval | str:
    if rows[metric.name].dtype.kind not in "fi":
        counts = Counter(rows[metric.name]).most_common()
        return ", ".join(f"{value} ({count})" for value, count in counts)
    return statistics.interval(_run_values(metric, rows), within=metric.range)


def _difference(metric: Metric, rows: pd.DataFrame, base: pd.DataFrame, method: str) -> Interval:
    values, baseline = _run_values(metric, rows), _run_values(metric, base)
    if method == PAIRED:
        return statistics.paired_difference(values, baseline, within=metric.range)
    exact = method == EXACT
    return statistics.difference(values, baseline, single_is_exact=exact, within=metric.range)


def _cell(metric: Metric, cell: Interval | str, better: bool) -> str:
    """Return a mean with its interval; of a clear difference with + or -."""
    if isinstance(cell, str):
        return cell
    clear = better and metric.more_is_better is not None and (cell.low > 0.0 or cell.high < 0.0)
    mark = (" +" if (cell.mean > 0.0) == metric.more_is_better else " -") if clear else ""
    return f"{cell}{mark}"
