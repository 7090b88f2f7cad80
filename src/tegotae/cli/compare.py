"""`tegotae compare`: controllers side by side, and how sure their differences are."""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae.cli.evaluate import evaluate_all, print_table, show
from tegotae.cli.tables import print_rows
from tegotae.collection import Runs, read
from tegotae.errors import TegotaeError
from tegotae.evaluation import Evaluation, Protocol
from tegotae.metrics.ranges import RANGES
from tegotae.metrics.statistics import Interval, difference, paired_difference

COMPARED = (
    "cot_inverse",
    "cot_inverse_total",
    "t0_s",
    "t1_s",
    "delta_omega",
    "delta_w",
    "cpgu",
    "limit_cycle_share",
    "smoothness",
)
"""The metrics whose differences are taken."""


@dataclass(frozen=True)
class Compare:
    """Compare controllers: files, folders or pure V models. Differences are to the first one."""

    places: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Controller files, folders of them, or names of pure V models."""
    drop: float = 0.2
    """How far the ground drops [m]."""
    energy: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Evaluate, compare, and print."""
        protocol = Protocol(drop_m=self.drop, work=self.energy)
        sets = told_apart([(place, runs) for place in self.places for runs in read(place)])
        if len(sets) < 2:
            raise TegotaeError(
                f"a comparison needs at least two sets of controllers; {len(sets)} found"
            )
        found = evaluate_all(sets, protocol)
        (base, base_evaluation), others = found[0], found[1:]
        differences = [
            (runs, paired(runs, base), compare(runs, evaluation, base, base_evaluation))
            for runs, evaluation in others
        ]
        if self.json:
            print(json.dumps(_document(found, differences)))
            return
        print_table(found)
        _print_differences(base, differences)


def told_apart(sets: Sequence[tuple[str, Runs]]) -> list[Runs]:
    """Sets of runs under names of their own: of those called alike, each with its place.

    Where the place is the same, too (as for a model at two frequencies), they are numbered.

    Args:
        sets: where each was found, and what.
    """
    names = [runs.name for _, runs in sets]
    for label in (lambda place, _: place, lambda _, number: f"no. {number}"):
        counts, seen = Counter(names), Counter()
        for i, name in enumerate(names):
            seen[name] += 1
            if counts[name] > 1:
                names[i] = f"{name} ({label(sets[i][0], seen[name])})"
    return [
        dataclasses.replace(runs, name=name) for name, (_, runs) in zip(names, sets, strict=True)
    ]


def paired(runs: Runs, base: Runs) -> bool:
    """Whether two sets are of the same seeds, so that their runs can be paired."""
    return runs.labels == base.labels and len(runs.labels) > 1


def compare(
    runs: Runs, evaluation: Evaluation, base: Runs, base_evaluation: Evaluation
) -> dict[str, Interval]:
    """Difference of each metric to the base's, paired by seed where the seeds agree."""
    take = paired_difference if paired(runs, base) else difference
    values, baseline = evaluation.runs(), base_evaluation.runs()
    return {name: take(values[name], baseline[name], within=RANGES[name]) for name in COMPARED}


def methods(is_paired: bool, by_metric: Mapping[str, Interval]) -> str:
    """How the runs were compared, and how the intervals of the metrics were found, in words."""
    used = dict.fromkeys(value.method for value in by_metric.values() if value.method)
    runs = "paired runs" if is_paired else "independent runs"
    return ", ".join([runs, " and ".join(used)] if used else [runs, "no interval"])


def _print_differences(base: Runs, differences: list) -> None:
    rows = (
        (
            runs.name,
            methods(is_paired, by_metric),
            *(show(by_metric[name]) for name in COMPARED),
        )
        for runs, is_paired, by_metric in differences
    )
    print_rows((f"minus {base.name}", "interval", *COMPARED), rows)


def _document(found: list, differences: list) -> dict:
    def plain(value: Interval) -> dict:
        entries = dataclasses.asdict(value).items()
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in entries}

    return {
        "controllers": [{"name": r.name, "labels": r.labels, **e.to_dict()} for r, e in found],
        "differences": [
            {
                "name": runs.name,
                "minus": found[0][0].name,
                "paired": is_paired,
                **{name: plain(value) for name, value in by_metric.items()},
            }
            for runs, is_paired, by_metric in differences
        ],
    }
