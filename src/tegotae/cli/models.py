"""`tegotae models`: models, designs and the zoo."""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae.cli.console import print_rows
from tegotae.measures.hopping.registry import metrics
from tegotae.systems.designs import Design, all_designs
from tegotae.systems.grammar import BUDGET
from tegotae.systems.models import Model, all_models
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


@dataclass(frozen=True)
class Models:
    """List the models of the study, designs for bodies with legs, or trained controllers."""

    pattern: Annotated[str, tyro.conf.Positional] = "*"
    """A name with * and ? as in a shell, or an architecture such as ART. A pattern with @ selects
    designs, such as '*@quadruped-c' or 'ART*@*'."""
    zoo: bool = False
    """List the trained controllers that come with the package, with their metrics: the best run of
    each model. MODEL/all lists every run, STUDY:MODEL those of one study."""
    json: bool = False
    """Print one JSON list instead of a table."""
    budget: int = BUDGET
    """Maximum number of trained parameters of a controller."""

    def run(self) -> None:
        """Print the list."""
        if self.zoo:
            if self.budget != BUDGET:
                raise TegotaeError(
                    "--budget sizes controllers that are not trained; those of --zoo are"
                )
            show(self.pattern, as_json=self.json)
            return
        if "@" in self.pattern:
            self._designs()
            return
        known = all_models()
        models = [
            model
            for name, model in known.items()
            if fnmatch.fnmatchcase(name, self.pattern) or model.architecture == self.pattern
        ]
        if not models:
            raise unknown("model", self.pattern, known)
        if self.json:
            print(json.dumps([describe(model, self.budget) for model in models], indent=1))
            return
        print_rows(
            ("model", "learned", "senses", "actuation", "ω_t", "weights"),
            (_row_models(describe(model, self.budget)) for model in models),
        )
        print(f"{len(models)} models")

    def _designs(self) -> None:
        known = all_designs()
        found = [known[name] for name in known if fnmatch.fnmatchcase(name, self.pattern)]
        if not found:
            raise unknown("design", self.pattern, known)
        rows = [describe_design(each, self.budget) for each in found]
        if self.json:
            print(json.dumps(rows, indent=1))
            return
        titles = ("design", "about", "ω", "weights")
        print_rows(titles, (tuple(map(str, each.values())) for each in rows))
        print(f"{len(rows)} designs")


def _row_models(model: dict) -> tuple[str, ...]:
    omega = model["omega_t_rad_per_s"]
    return (
        model["name"],
        "".join(model["learned_terms"]) or "-",
        ", ".join(name.removeprefix("spring_") for name in model["observation"]),
        model["actuation"],
        "-" if omega is None else f"{omega:g}",
        str(model["parameters"]),
    )


def describe(model: Model, budget: int = BUDGET) -> dict:
    """A model as JSON values."""
    return {
        "name": model.name,
        "architecture": model.architecture,
        "learned_terms": list(model.learned_terms),
        "observation": list(model.observation),
        "reaction_observation": model.reaction,
        "gain_observation": model.gain,
        "actuation": model.actuation_name,
        "omega_t_rad_per_s": model.omega_t,
        "parameters": model.controller(budget).n_weights,
    }


def describe_design(design: Design, budget: int = BUDGET) -> dict:
    """A design as JSON values."""
    return {
        "name": design.name,
        "about": design.family.about,
        "omega_rad_per_s": design.frequency if design.family.has_rhythm else None,
        "parameters": design.controller(budget).n_weights,
    }
