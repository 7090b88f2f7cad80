"""The paper's evaluation of controllers on one leg."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from tegotae._support.progress import reporting
from tegotae.cli.tables import print_rows, print_text
from tegotae.measures.evaluation import Evaluation, evaluate, require_evaluable
from tegotae.measures.hopping.metric import TABLE, Metric
from tegotae.measures.hopping.registry import metrics
from tegotae.measures.hopping.statistics import Interval
from tegotae.systems.controller_set import ControllerSet


def shown(asked: tuple[Metric, ...] | None) -> tuple[Metric, ...]:
    """The metrics of a table on the screen: those asked for, or the usual ones."""
    return metrics(TABLE) if asked is None else asked


def evaluate_all(
    sets: list[ControllerSet],
    protocol: Mapping[str, Any],
    omega: float | None = None,
    asked: tuple[Metric, ...] | None = None,
) -> list[tuple[ControllerSet, Evaluation]]:
    """Evaluate sets of runs, showing how far it is.

    Each is released, integrated and evaluated as its own system and protocol say.

    Args:
        sets: the runs.
        protocol: fields of the protocol in place of each set's own.
        omega: frequency around which all are evaluated [rad/s]; each one's own by default.
        asked: the metrics that are asked for; all by default.
    """
    protocols = [dataclasses.replace(runs.protocol, **protocol) for runs in sets]
    for runs, own in zip(sets, protocols, strict=True):
        require_evaluable(runs.controller, runs.body, own)
    found = []
    with reporting("evaluate", len(sets)) as reporter:
        for runs, own in zip(sets, protocols, strict=True):
            # A frequency asked for does not give one to a controller without an oscillator.
            omega_t = runs.omega_t if omega is None or runs.omega_t is None else omega
            there = runs.replaced(omega=omega_t)
            result = evaluate(
                runs.controller,
                runs.weights,
                omega_t,
                runs.body,
                own,
                metrics=asked,
                start=runs.system.scenario(),
                integrator=runs.system.integrator,
            )
            found.append((there, result))
            reporter.update(len(found), runs.name)
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
        turned=True,
    )
    print_text(
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


def columns(found: list[tuple[ControllerSet, Evaluation]]) -> dict[str, list[str]]:
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
