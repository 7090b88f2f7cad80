"""Controllers side by side on the environment that they were trained on."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Sequence

from tegotae._support.errors import TegotaeError
from tegotae.cli.on_environment.evaluate import Rows, evaluate_all, per_run, print_table, range_of
from tegotae.cli.on_environment.simulate import LABELS
from tegotae.cli.one_leg.evaluate import show
from tegotae.cli.tables import print_rows, print_text
from tegotae.measures.hopping.statistics import Interval, difference, paired_difference
from tegotae.systems.controller_set import ControllerSet

STARTS = 8
"""Episodes of each run, on an environment with noise."""

IsPaired = Callable[[ControllerSet, ControllerSet], bool]


def compare_on_environment(
    sets: Sequence[ControllerSet], paired: IsPaired, *, as_json: bool
) -> None:
    """Play all, and print what each is and how it differs from the first.

    Args:
        sets: the runs, under names of their own.
        paired: whether the runs of two sets are to be paired, seed by seed.
        as_json: whether to print one JSON object.

    Raises:
        TegotaeError: for sets on different environments.
    """
    require_one_environment(sets)
    rows = [evaluate_all([runs], STARTS) for runs in sets]
    rows = [[(runs.name, label, start, x) for _, label, start, x in own]
            for runs, own in zip(sets, rows, strict=True)]  # fmt: skip
    whole: Rows = [row for own in rows for row in own]
    quantities = [name for name in LABELS if any(name in numbers for *_, numbers in whole)]
    base = sets[0]
    found: dict[str, dict[str, Interval]] = {}
    for runs in sets[1:]:
        take = paired_difference if paired(runs, base) else difference
        found[runs.name] = {
            name: take(
                per_run(whole, runs.name, name),
                per_run(whole, base.name, name),
                within=range_of(name),
            )
            for name in quantities
        }
    if as_json:
        print(json.dumps(_document(base.name, whole, found)))
        return
    print_table(whole)
    print_rows(
        (f"minus {base.name}", *found),
        [
            (_label(name), *(show(by_name[name]) for by_name in found.values()))
            for name in quantities
        ],
    )
    print_text(
        "Runs are paired, seed by seed, where they share what is random: controller and algorithm."
    )


def require_one_environment(sets: Sequence[ControllerSet]) -> None:
    """Raise `TegotaeError` unless all sets were trained on the same environment."""
    first, *others = sets
    for runs in others:
        if first.task is None or runs.task is None:
            ours = first if first.task is None else runs
            raise TegotaeError(f"{ours.name} is on this package's engine, and others are not")
        if runs.task.env != first.task.env or runs.task.settings != first.task.settings:
            raise TegotaeError(
                f"{first.name} is on {first.task.env} and {runs.name} on {runs.task.env}, or with "
                "other settings; controllers are compared on one environment"
            )


def _label(name: str) -> str:
    what, unit = LABELS[name]
    return f"{what} [{unit}]" if unit else what


def _document(base: str, rows: Rows, found: dict[str, dict[str, Interval]]) -> dict[str, object]:
    def plain(value: Interval) -> dict[str, object]:
        entries = dataclasses.asdict(value).items()
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in entries}

    return {
        "episodes": [
            {"name": name, "run": label, "start": start,
             **{n: x if math.isfinite(x) else None for n, x in numbers.items()}}
            for name, label, start, numbers in rows
        ],
        "differences": [
            {"name": name, "minus": base, **{n: plain(x) for n, x in each.items()}}
            for name, each in found.items()
        ],
    }  # fmt: skip
