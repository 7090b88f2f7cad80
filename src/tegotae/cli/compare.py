"""`tegotae compare`: controllers side by side, and how sure their differences are."""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import tyro

from tegotae.cli.evaluate import evaluate_all, print_table, show, shown
from tegotae.cli.metrics import named
from tegotae.cli.options import WorkOption
from tegotae.cli.tables import print_rows
from tegotae.collection import Runs, read
from tegotae.errors import TegotaeError
from tegotae.evaluation import Evaluation, Protocol
from tegotae.metrics.metric import Metric
from tegotae.metrics.registry import range_of
from tegotae.metrics.statistics import Interval, difference, paired_difference


@dataclass(frozen=True, kw_only=True)
class Compare(WorkOption):
    """Compare controllers: files, folders or pure V models. Differences are to the first one."""

    places: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Controller files, folders of them, or names of pure V models."""
    drop: float = 0.2
    """How far the ground drops [m]."""
    metric: tuple[str, ...] = ()
    """Only these metrics: names, FILE.py:OBJECT for one of your own, or all."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Evaluate, compare, and print."""
        protocol = Protocol(drop_m=self.drop, work=self.work)
        asked = named(self.metric)
        sets = told_apart([(place, runs) for place in self.places for runs in read(place)])
        if len(sets) < 2:
            raise TegotaeError(
                f"a comparison needs at least two sets of controllers; {len(sets)} found"
            )
        found = evaluate_all(sets, protocol, asked=asked)
        (base, base_evaluation), others = found[0], found[1:]
        differences = [
            (runs, paired(runs, base), compare(runs, evaluation, base, base_evaluation))
            for runs, evaluation in others
        ]
        if self.json:
            print(json.dumps(_document(found, differences)))
            return
        print_table(found, shown(asked))
        _print_differences(base, differences, shown(asked))


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
    """Whether the runs of two sets share what is random, seed by seed, and so can be paired.

    From a seed are drawn the first weights, what the algorithm tries, and the conditions of its
    episodes: they are the same in both if seeds, controller, algorithm and conditions are.
    """
    ours, theirs = _random(runs), _random(base)
    return ours is not None and ours == theirs and len(runs.labels) > 1


def _random(runs: Runs) -> tuple[Any, ...] | None:
    """All that decides what is drawn in a training; None if that is not known."""
    experiment, algorithm = runs.training.get("experiment"), runs.training.get("algorithm")
    if not isinstance(experiment, Mapping) or algorithm is None:
        return None
    drawn = (experiment.get("conditions"), experiment.get("episodes"))
    return runs.labels, runs.controller, algorithm, drawn


def compare(
    runs: Runs, evaluation: Evaluation, base: Runs, base_evaluation: Evaluation
) -> dict[str, Interval]:
    """Difference of each metric to the base's, of paired runs where they are (`paired`)."""
    take = paired_difference if paired(runs, base) else difference
    values, baseline = evaluation.runs(), base_evaluation.runs()
    return {name: take(row, baseline[name], within=range_of(name)) for name, row in values.items()}


def methods(is_paired: bool, by_metric: Mapping[str, Interval]) -> str:
    """How the runs were compared, and how the intervals of the metrics were found, in words."""
    used = dict.fromkeys(value.method for value in by_metric.values() if value.method)
    runs = "paired runs" if is_paired else "independent runs"
    return ", ".join([runs, " and ".join(used)] if used else [runs, "no interval"])


def _print_differences(base: Runs, differences: list, shown: tuple[Metric, ...]) -> None:
    rows = (
        (
            runs.name,
            methods(is_paired, {metric.name: by_metric[metric.name] for metric in shown}),
            *(_judged(metric, by_metric[metric.name]) for metric in shown),
        )
        for runs, is_paired, by_metric in differences
    )
    headings = (metric.heading for metric in shown)
    print_rows((f"minus {base.name}", "interval", *headings), rows)
    print("+ is better and - is worse, where the interval of the difference leaves zero out.")
    print(
        "Runs are paired, seed by seed, where they share what is random: controller, algorithm and "
        "conditions."
    )


def _judged(metric: Metric, value: Interval) -> str:
    """A difference in a table, with whether it is for the better."""
    clear = value.low > 0.0 or value.high < 0.0
    if not clear or metric.more_is_better is None:
        return show(value)
    return f"{show(value)} {'+' if (value.mean > 0.0) == metric.more_is_better else '-'}"


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
