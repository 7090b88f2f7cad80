"""`tegotae evaluate`: the paper's evaluation of controllers."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from tegotae._support import tables
from tegotae._support.errors import require_finite
from tegotae._support.files import output_file
from tegotae._support.limits import MOST_RAD_PER_S
from tegotae._support.progress import reporting
from tegotae.cli.metrics import named
from tegotae.cli.options import UNSET, BodyOptions, WorkOption
from tegotae.cli.tables import print_rows
from tegotae.measures.evaluation import (
    Evaluation,
    Protocol,
    evaluate,
    require_evaluable,
)
from tegotae.measures.hopping.metric import TABLE, Metric
from tegotae.measures.hopping.registry import metrics
from tegotae.measures.hopping.statistics import Interval
from tegotae.systems.controller_set import ControllerSet
from tegotae.training.collection import read


@dataclass(frozen=True, kw_only=True)
class Evaluate(WorkOption, BodyOptions):
    """Evaluate a controller file, a folder of them, or a pure V model, at five frequencies.

    Options of the body put every controller on another one than it was trained on.
    """

    place: Annotated[str, tyro.conf.Positional]
    """A controller file, a folder, or the name of a pure V model such as V-sector-w4."""
    omega: Annotated[float | None, UNSET] = None
    """Evaluate around this frequency [rad/s] instead of the one trained at."""
    drop: float = 0.2
    """How far the ground drops [m]."""
    undisturbed: float = 40.0
    """Time from the release to the drop [s]."""
    disturbed: float = 40.0
    """Time after that [s]."""
    metric: tuple[str, ...] = ()
    """Only these metrics: names, FILE.py:OBJECT for one of your own, or all; without it, all are
    computed and the usual ones shown. What they do not need is not simulated."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Also write one row per run to this file."""

    def run(self) -> None:
        """Evaluate, and print."""
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        protocol = Protocol(
            drop_m=self.drop,
            undisturbed_s=self.undisturbed,
            disturbed_s=self.disturbed,
            work=self.work,
        )
        asked = named(self.metric)
        if self.csv is not None:
            output_file(self.csv)
        sets = [self._on_body(runs) for runs in read(self.place)]
        found = evaluate_all(sets, protocol, self.omega, asked)
        if self.csv is not None:
            tables.write_csv(self.csv, _columns(found))
        if self.json:
            controllers = [{"name": r.name, "labels": r.labels, **e.to_dict()} for r, e in found]
            print(json.dumps({"controllers": controllers}))
            return
        print_table(found, shown(asked))

    def _on_body(self, runs: ControllerSet) -> ControllerSet:
        return runs.replaced(body=self.in_place_of(runs.body))


def shown(asked: tuple[Metric, ...] | None) -> tuple[Metric, ...]:
    """The metrics of a table on the screen: those asked for, or the usual ones."""
    return metrics(TABLE) if asked is None else asked


def evaluate_all(
    sets: list[ControllerSet],
    protocol: Protocol,
    omega: float | None = None,
    asked: tuple[Metric, ...] | None = None,
) -> list[tuple[ControllerSet, Evaluation]]:
    """Evaluate sets of runs by all metrics, or those asked for, showing how far it is."""
    for runs in sets:
        require_evaluable(runs.controller, runs.body, protocol)
    found = []
    with reporting("evaluate", len(sets)) as reporter:
        for done, runs in enumerate(sets, 1):
            # A frequency asked for does not give one to a controller without an oscillator.
            omega_t = runs.omega_t if omega is None or runs.omega_t is None else omega
            there = runs.replaced(omega=omega_t)
            result = evaluate(
                runs.controller, runs.weights, omega_t, runs.body, protocol, metrics=asked
            )
            found.append((there, result))
            reporter.update(done, runs.name)
    return found


def print_table(found: list[tuple[ControllerSet, Evaluation]], shown: tuple[Metric, ...]) -> None:
    """One row per set of runs: mean and 95 % interval of each metric over the runs."""
    summaries = [evaluation.summary() for _, evaluation in found]
    print_rows(
        ("controller", "runs", *(metric.heading for metric in shown)),
        (
            (runs.name, str(evaluation.n_runs), *(show(summary[m.name]) for m in shown))
            for (runs, evaluation), summary in zip(found, summaries, strict=True)
        ),
    )
    print(
        "Mean over runs [95 % interval]. A body at rest has CoT⁻¹ 0; hopping without a "
        "limit cycle has neither CoT⁻¹ nor transients, and counts in the share of limit cycles. "
        "– is undefined, * means that some runs are."
    )


def show(value: Interval) -> str:
    """An interval in a table."""
    if math.isnan(value.mean):
        return "–"
    mark = "*" if value.undefined else ""
    if math.isnan(value.low):
        return f"{value.mean:.3g}{mark}"
    return f"{value.mean:.3g}{mark} [{value.low:.3g}, {value.high:.3g}]"


def _columns(found: list[tuple[ControllerSet, Evaluation]]) -> dict[str, list[str]]:
    """One row per run: where it is from, and every metric that was asked for."""
    columns: dict[str, list[str]] = {}
    for runs, evaluation in found:
        omega = "" if runs.omega_t is None else f"{runs.omega_t:g}"
        own = {
            "controller": [runs.name] * len(runs.labels),
            "run": list(runs.labels),
            "omega_t_rad_per_s": [omega] * len(runs.labels),
            **{name: [*map(_cell, values)] for name, values in evaluation.runs().items()},
        }
        for name, cells in own.items():
            columns.setdefault(name, []).extend(cells)
    return columns


def _cell(value: np.floating) -> str:
    return "" if np.isnan(value) else f"{value:.6g}"
