"""`tegotae models`: the 218 models of the study, designs for legs, and trained controllers."""

from __future__ import annotations

import fnmatch
import json
from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae._support.errors import TegotaeError, unknown
from tegotae.cli import zoo_table
from tegotae.cli.tables import print_rows
from tegotae.systems.designs import Design, all_designs
from tegotae.systems.grammar import BUDGET
from tegotae.systems.models import Model, all_models


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
            zoo_table.show(self.pattern, as_json=self.json)
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
            (_row(describe(model, self.budget)) for model in models),
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


def _row(model: dict) -> tuple[str, ...]:
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
