"""Controllers on the environment that they were trained on, with intervals over runs."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae.cli.env_options import made_with
from tegotae.cli.on_environment.simulate import LABELS
from tegotae.cli.one_leg.evaluate import show
from tegotae.cli.tables import print_rows, print_text
from tegotae.measures.hopping.statistics import UNBOUNDED, Range, interval
from tegotae.systems.controller_set import ControllerSet
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import replay

Rows = list[tuple[str, str, int, dict[str, float]]]
"""Set, run, start, and its numbers."""


def evaluate_all(
    sets: Sequence[ControllerSet],
    starts: int,
    settings: Sequence[str] = (),
    omegas: Sequence[float] = (),
) -> Rows:
    """Play episodes of every run.

    Args:
        sets: the runs; each set on its own environment.
        starts: episodes of each, from other starts where the environment has several.
        settings: NAME=VALUE each, in which the environment is to differ from the training.
        omegas: frequencies [rad/s], a set each if there are several; the training's by default.
    """
    rows: Rows = []
    for runs in sets:
        experiment = EnvExperiment.of_set(runs)
        changed = dict(made_with((), None, settings, is_model=True))
        own = tuple({**dict(experiment.spec.settings), **changed}.items())
        experiment = replace(experiment, spec=replace(experiment.spec, settings=own))
        varied = not experiment.spec.is_model or experiment.spec.model_settings.noise > 0.0
        at = omegas or experiment.omegas or (experiment.wiring.omega,)
        for omega in at:
            own = replace(experiment, wiring=replace(experiment.wiring, omega=omega))
            name = f"{runs.name} at ω {omega:g}" if len(at) > 1 else runs.name
            for start in range(starts if varied else 1):
                found = replay(own, runs.weights, seed=experiment.seed + start)
                rows += [
                    (name, label, start, each.numbers())
                    for label, each in zip(runs.labels, found, strict=True)
                ]
    return rows


def print_table(rows: Rows) -> None:
    """A line a quantity, a column a set: mean and 95 % interval over runs."""
    names = list(dict.fromkeys(name for name, *_ in rows))
    measured = [n for n in LABELS if any(n in numbers for *_, numbers in rows)]
    print_rows(
        ("quantity", *(f"{name} ({len(_labels(rows, name))} runs)" for name in names)),
        [
            (
                f"{LABELS[n][0]} [{LABELS[n][1]}]" if LABELS[n][1] else LABELS[n][0],
                *(show(interval(per_run(rows, name, n), within=range_of(n))) for name in names),
            )
            for n in measured
        ],
    )
    print_text(
        "Mean over runs [95 % interval]; the mean of a run is over its starts. – is undefined: "
        "without a limit cycle there is neither CoT⁻¹ nor a transient. * means that some runs are."
    )


def per_run(rows: Rows, name: str, quantity: str) -> np.ndarray:
    """Of every run of a set the mean over its starts; NaN where all are undefined."""
    values = []
    for label in _labels(rows, name):
        own = [
            numbers.get(quantity, math.nan) for n, r, _, numbers in rows if (n, r) == (name, label)
        ]
        sound = [x for x in own if not math.isnan(x)]
        values.append(sum(sound) / len(sound) if sound else math.nan)
    return np.array(values)


def write(rows: Rows, csv: Path) -> None:
    """A row per run and start."""
    measured = [n for n in LABELS if any(n in numbers for *_, numbers in rows)]
    columns: dict[str, list[object]] = {
        "controller": [name for name, *_ in rows],
        "run": [label for _, label, *_ in rows],
        "start": [start for _, _, start, _ in rows],
        **{n: [numbers.get(n, math.nan) for *_, numbers in rows] for n in measured},
    }
    tables.write_csv(csv, columns, digits=6)  # type: ignore[arg-type]


def print_json(rows: Rows) -> None:
    """All rows as one JSON object."""
    listed = [
        {"name": name, "run": label, "start": start,
         **{n: x if math.isfinite(x) else None for n, x in numbers.items()}}
        for name, label, start, numbers in rows
    ]  # fmt: skip
    print(json.dumps({"episodes": listed}))


def require_environment(sets: Sequence[ControllerSet], place: str) -> None:
    """Raise `TegotaeError` where some runs were trained elsewhere."""
    if any(runs.task is None for runs in sets):
        raise TegotaeError(
            f"{place} has controllers that were trained on an environment and others; name their "
            "folders apart"
        )


def range_of(quantity: str) -> Range:
    """Least and largest possible value."""
    if quantity in ("lasted", "duty"):
        return (0.0, 1.0)
    signed = ("fitness", "return", "distance_m", "speed_m_per_s", "stride_hz")
    return UNBOUNDED if quantity in signed else (0.0, math.inf)


def _labels(rows: Rows, name: str) -> list[str]:
    return list(dict.fromkeys(label for n, label, *_ in rows if n == name))
