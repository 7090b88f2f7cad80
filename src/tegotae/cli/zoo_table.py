"""The trained controllers of the zoo as a table, with metrics of their evaluation."""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Iterable, Iterator

from tegotae._support.documents import JsonObject
from tegotae._support.errors import unknown
from tegotae.cli.tables import print_rows
from tegotae.measures.hopping.registry import metrics
from tegotae.systems.zoo import ALL, Zoo, ZooName, studies, study_of

SHOWN = ("cot_inverse", "t0_s", "t1_s")
"""The metrics of a row, where there are any of these; else the first ones. JSON has all."""


def show(pattern: str, *, as_json: bool) -> None:
    """Print the controllers of a pattern.

    Args:
        pattern: `[STUDY:]MODEL[/RUN]`, MODEL with * and ? as in a shell or an architecture.
        as_json: print one JSON list, with all metrics.

    Raises:
        TegotaeError: if there are none, with the nearest names.
    """
    wanted = ZooName.of(pattern)
    zoos = (study_of(wanted.study),) if wanted.study else studies()
    first: dict[str, str] = {}
    for zoo in zoos:
        for model in zoo.models:
            first.setdefault(model, zoo.study)
    found = [
        entry
        for zoo in zoos
        for model in _models(zoo, wanted.model)
        # Without a study's name, a model is looked for in the first that has it.
        for study in [wanted.study or ("" if first[model] == zoo.study else zoo.study)]
        for entry in _entries(zoo, ZooName(study, model, wanted.run))
    ]
    if not found:
        known = [model for zoo in zoos for model in zoo.models]
        raise unknown("trained controller", f"{wanted.model}/{wanted.run}".rstrip("/"), known)
    if as_json:
        print(json.dumps(found, indent=1))
        return
    headings = {metric.name: metric.heading for metric in metrics()}
    held = {name: None for zoo in zoos for name in zoo.metrics}
    shown = [name for name in SHOWN if name in held] or list(held)[: len(SHOWN)]
    titles = ("controller", "fitness", *(headings.get(name, name) for name in shown))
    print_rows(titles, (_row(entry, shown) for entry in found))
    made = ", ".join(
        f"{zoo.study} by tegotae {zoo.software.get('tegotae')}, {zoo.software.get('engine')} engine"
        for zoo in zoos
    )
    print(f"{len(found)} controllers; studies: {made}")


def _models(zoo: Zoo, pattern: str) -> list[str]:
    return [
        model
        for model in zoo.models
        if fnmatch.fnmatchcase(model, pattern) or model.partition("-")[0] == pattern
    ]


def _entries(zoo: Zoo, name: ZooName) -> Iterator[JsonObject]:
    """The controllers of a model as JSON values: the best run, or those that are asked for."""
    columns = zoo.runs(name.model)
    asked = {"": str(zoo.best(name.model)), ALL: "*"}.get(name.run, name.run)
    for run in range(zoo.models[name.model]):
        if fnmatch.fnmatchcase(str(run), asked):
            known = {each: values[run].item() for each, values in columns.items()}
            yield {
                "name": str(ZooName(name.study, name.model, str(run))),
                "study": zoo.study,
                "software": zoo.software,
                **{each: None if value != value else value for each, value in known.items()},
            }


def _row(entry: JsonObject, shown: Iterable[str]) -> tuple[str, ...]:
    numbers = (entry.get(name) for name in ("fitness", *shown))
    return (str(entry["name"]), *("–" if each is None else f"{each:.3g}" for each in numbers))
