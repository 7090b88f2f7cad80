"""`tegotae compare`: controllers side by side, and how sure their differences are."""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import tyro

from tegotae._support.errors import TegotaeError
from tegotae.cli.console import print_rows, print_text
from tegotae.cli.evaluate import named
from tegotae.cli.extras import require_environments
from tegotae.cli.hopping import evaluate_all, print_table, show, shown
from tegotae.cli.options import UNSET, ProtocolOptions, refuse_on_environment
from tegotae.measures.evaluation import Evaluation
from tegotae.measures.hopping.metric import Metric
from tegotae.measures.hopping.registry import range_of
from tegotae.measures.hopping.statistics import Interval, difference, paired_difference
from tegotae.systems.controller_set import ControllerSet
from tegotae.training.collection import gathered


@dataclass(frozen=True, kw_only=True)
class Compare(ProtocolOptions):
    """Compare controllers: files, folders or pure V models. Differences are relative to the first.

    Every controller has the release and the integrator of its own system. All have the same
    protocol: the one that their experiments share, or that of the options. Controllers that were
    trained on the same environment run there again.
    """

    places: Annotated[tuple[str, ...], tyro.conf.Positional]
    """At least two controller files, folders of them, or names of pure V models."""
    metric: Annotated[tuple[str, ...], UNSET] = ()
    """Compute only these metrics: names, your own as FILE.py:OBJECT, or all."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Evaluate, compare, and print."""
        protocol = self.changed()
        asked = named(self.metric)
        sets = with_distinct_names(gathered(self.places))
        if len(sets) < 2:
            raise TegotaeError(
                f"a comparison needs at least two sets of controllers; {len(sets)} found"
            )
        if any(runs.task is not None for runs in sets):
            self._on_environment(sets)
            return
        require_alike(sets, protocol)
        found = evaluate_all(sets, protocol, asked=asked)
        (base, base_evaluation), others = found[0], found[1:]
        differences = [
            (runs, compared_as(runs, base), compare(runs, evaluation, base, base_evaluation))
            for runs, evaluation in others
        ]
        if self.json:
            print(json.dumps(_document(found, differences)))
            return
        print_table(found, shown(asked))
        _print_differences(base, differences, shown(asked))

    def _on_environment(self, sets: Sequence[ControllerSet]) -> None:
        require_environments(runs.task for runs in sets)
        from tegotae.cli.wired import compare_on_environment

        refuse_on_environment(self, ("places", "json"), sets[0].name)
        compare_on_environment(sets, paired, as_json=self.json)


def with_distinct_names(sets: Sequence[tuple[str, ControllerSet]]) -> list[ControllerSet]:
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


def require_alike(sets: Sequence[ControllerSet], given: Mapping[str, Any]) -> None:
    """Raise `TegotaeError` if sets are evaluated by protocols that cannot be compared.

    Heights of release and control periods belong to the systems, and may differ.
    """
    of_systems = ("release_m", "tick_s")
    protocols = [dataclasses.asdict(dataclasses.replace(x.protocol, **given)) for x in sets]
    for runs, own in zip(sets, protocols, strict=True):
        for name, value in own.items():
            if name not in of_systems and value != protocols[0][name]:
                raise TegotaeError(
                    f"{sets[0].name} and {runs.name} are evaluated with another {name}, "
                    f"{protocols[0][name]} and {value}; --drop and --work set one for all"
                )


def paired(runs: ControllerSet, base: ControllerSet) -> bool:
    """Whether the runs of two sets share what is random, seed by seed, and so can be paired.

    From a seed are drawn the first weights, what the algorithm tries, and the conditions of its
    episodes: they are the same in both if seeds, controller, algorithm and conditions are.
    """
    ours, theirs = _random(runs), _random(base)
    return ours is not None and ours == theirs and len(runs.labels) > 1


def _random(runs: ControllerSet) -> tuple[object, ...] | None:
    """All that decides what is drawn in a training; None if that is not known."""
    algorithm = runs.training.get("algorithm")
    if algorithm is None:
        return None
    drawn = (runs.training.get("conditions") or [], runs.training.get("episodes", 1))
    return runs.labels, runs.controller, algorithm, drawn


def is_exact(runs: ControllerSet) -> bool:
    """Whether a run is no sample of many: all there is is a gain, which a search finds.

    Between two trainings of such a controller nothing differs.
    """
    return len(runs.labels) == 1 and runs.controller.has_a_gain_alone


def compare(
    runs: ControllerSet, evaluation: Evaluation, base: ControllerSet, base_evaluation: Evaluation
) -> dict[str, Interval]:
    """Difference of each metric to the base's, of paired runs where they are (`paired`)."""
    how = compared_as(runs, base)
    unpaired = partial(difference, single_is_exact=how == EXACT)
    take = paired_difference if how == PAIRED else unpaired
    values, baseline = evaluation.runs(), base_evaluation.runs()
    return {name: take(row, baseline[name], within=range_of(name)) for name, row in values.items()}


PAIRED, INDEPENDENT, EXACT = "paired runs", "independent runs", "one run is exact"
"""How two sets of runs are compared."""


def compared_as(runs: ControllerSet, base: ControllerSet) -> str:
    """How two sets of runs are compared."""
    if paired(runs, base):
        return PAIRED
    return EXACT if is_exact(runs) or is_exact(base) else INDEPENDENT


def methods(runs: str, by_metric: Mapping[str, Interval]) -> str:
    """How the runs were compared, and how the intervals of the metrics were found, in words."""
    used = dict.fromkeys(value.method for value in by_metric.values() if value.method)
    return ", ".join([runs, " and ".join(used)] if used else [runs, "no interval"])


def _print_differences(base: ControllerSet, differences: list, shown: tuple[Metric, ...]) -> None:
    rows = (
        (
            runs.name,
            methods(how, {metric.name: by_metric[metric.name] for metric in shown}),
            *(_evaluated(metric, by_metric[metric.name]) for metric in shown),
        )
        for runs, how, by_metric in differences
    )
    headings = (metric.heading for metric in shown)
    print_rows((f"minus {base.name}", "interval", *headings), rows, turned=True)
    print_text("+ is better and - is worse, where the interval of the difference leaves zero out.")
    print_text(
        "Runs are paired, seed by seed, where they share what is random: controller, algorithm and "
        "conditions."
    )
    if any(how == EXACT for _, how, _ in differences):
        print_text(
            "A gain that a search found is exact: no other run would differ. Against it the "
            "interval is that of the other runs alone; between two exact ones there is none."
        )


def _evaluated(metric: Metric, value: Interval) -> str:
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
                "paired": how == PAIRED,
                "exact": how == EXACT,
                **{name: plain(value) for name, value in by_metric.items()},
            }
            for runs, how, by_metric in differences
        ],
    }
