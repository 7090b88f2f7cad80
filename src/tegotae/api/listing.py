"""Recipes and trained controllers by name."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator

import pandas as pd

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae.api.parameters import check_types
from tegotae.api.results import Table, short
from tegotae.measures.gaits.metrics import WALKING
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.robots import ROBOTS
from tegotae.systems.recipe import Recipe, recipe, recipes_on_legs, study_recipes
from tegotae.systems.term_sets import BUDGET, LAWS, ShortLaw
from tegotae.systems.zoo import ALL, Zoo, ZooName, studies, study_of

_ON_SCREEN = ("cot_inverse", "t0_s", "t1_s")
"""The metrics of a trained controller on the screen, where there are any of these; else the first
ones. JSON has all."""


@check_types
def list_models(pattern: str = "*", *, zoo: bool = False, budget: int = BUDGET) -> Table:
    """List the models of the study and short laws, recipes on legs, or trained controllers.

    Args:
        pattern: a name with * and ? as in a shell, or an architecture such as ART. A pattern with @
            selects recipes on legs, such as '*@quadruped-c' or 'ART*@*'.
        zoo: list the trained controllers that come with the package, with their metrics: the best
            run of each model. MODEL/all lists every run, STUDY:MODEL those of one study.
        budget: maximum number of trained parameters of a controller.

    Raises:
        TegotaeError: for a pattern that nothing matches.

    Example:
        >>> list_models("V-sector-*").table["name"].tolist()
        ['V-sector-w4', 'V-sector-w8']
    """
    if zoo:
        if budget != BUDGET:
            raise TegotaeError("budget sizes controllers that are not trained; those of zoo are")
        return _trained(pattern)
    if "@" in pattern:
        kind, recipes = "recipe", recipes_on_legs()
        headings, described = _OF_LEGS, _on_legs
    else:
        kind, recipes = "model", _hopper_recipes(budget)
        headings, described = _OF_HOPPER, _recipe_row
    matches = [x for name, x in recipes.items() if fnmatch.fnmatchcase(name, pattern)]
    matches = matches or [x for x in recipes.values() if x.terms.architecture == pattern]
    if not matches:
        raise unknown(kind, pattern, recipes)
    laws = 0 if kind == "recipe" else sum(isinstance(x.terms, ShortLaw) for x in matches)
    counts = {f"{kind}s": len(matches) - laws, "short laws": laws}
    remark = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    rows = [described(x, budget) for x in matches]
    return _listed(rows, headings, remark)


@check_types
def list_metrics(pattern: str = "*") -> Table:
    """List the metrics of hopping, of walking on several legs, and of robots.

    `--metric` of evaluate and compare takes their names. Your own are listed with --parts FILE.py.

    Args:
        pattern: a name with * and ? as in a shell.

    Raises:
        TegotaeError: for a pattern that nothing matches.

    Example:
        >>> list_metrics("saturated*").table[["metric", "of"]].values.tolist()
        [['saturated_share', 'robots']]
    """
    available = [(x, kind.kind) for kind in _CATALOGUES for x in kind.metrics()]
    better = {True: "more", False: "less", None: ""}
    rows = [
        (x.name, kind, x.label, x.unit, better[x.more_is_better], x.about)
        for x, kind in available
        if fnmatch.fnmatchcase(x.name, pattern)
    ]
    if not rows:
        raise unknown("metric", pattern, {x.name: kind for x, kind in available})
    table = pd.DataFrame(rows, columns=["metric", "of", "label", "unit", "better", "about"])
    view = table.drop(columns="label").set_index("metric")
    return Table(rows=table, views=[view], data={"metrics": table.to_dict("records")})


_CATALOGUES = (HOPPING, WALKING, ROBOTS)

_OF_HOPPER = {
    "name": "model",
    "learned_terms": "learned",
    "observation": "senses",
    "actuation": "actuation",
    "omega_t_rad_per_s": "ω_t",
    "parameters": "weights",
}
_OF_LEGS = {
    "name": "recipe",
    "about": "about",
    "omega_rad_per_s": "ω",
    "parameters": "weights",
}


def _hopper_recipes(budget: int) -> dict[str, Recipe]:
    """Return the models, and the short laws of so many numbers at the study's frequencies, by
    name.
    """
    laws = [recipe(f"{law}-w{omega}") for law in LAWS for omega in (4, 8)]
    fitting = {law.name: law for law in laws if law.controller().n_weights <= budget}
    return {**study_recipes(), **fitting}


def _recipe_row(entry: Recipe, budget: int) -> JsonObject:
    terms, learned = entry.terms, entry.learned_terms
    return {
        "name": entry.name,
        "architecture": terms.architecture,
        "learned_terms": [*terms.learned],
        "observation": [*entry.observation],
        "reaction_observation": learned.reaction,
        "gain_observation": learned.gain,
        "actuation": entry.actuation,
        "omega_t_rad_per_s": entry.omega_t,
        "parameters": entry.controller(budget).n_weights,
    }


def _on_legs(entry: Recipe, budget: int) -> JsonObject:
    return {
        "name": entry.name,
        "about": entry.terms.about,
        "omega_rad_per_s": entry.omega_t,
        "parameters": entry.controller(budget).n_weights,
    }


def _trained(pattern: str) -> Table:
    """Return the trained controllers of `[STUDY:]MODEL[/RUN]`."""
    query = ZooName.parse(pattern)
    zoos = (study_of(query.study),) if query.study else studies()
    first = {model: zoo.study for zoo in reversed(zoos) for model in zoo.models}
    rows = [
        row
        for zoo in zoos
        for model in zoo.models
        if fnmatch.fnmatchcase(model, query.model) or model.partition("-")[0] == query.model
        # Without a study's name, a model is looked for in the first that has it.
        for study in [query.study or ("" if first[model] == zoo.study else zoo.study)]
        for row in _runs(zoo, ZooName(study, model, query.run))
    ]
    if not rows:
        raise unknown("trained controller", f"{query.model}/{query.run}".rstrip("/"), first)
    metrics_held = (name for zoo in zoos for name in zoo.metrics)
    held = dict.fromkeys(name for name in metrics_held if any(name in row for row in rows))
    visible = [name for name in _ON_SCREEN if name in held] or [*held][: len(_ON_SCREEN)]
    heading_by_metric = {metric.name: metric.heading for metric in HOPPING.metrics()}
    counts = ", ".join(
        f"{zoo.study} by tegotae {zoo.software.get('tegotae')}, {zoo.software.get('engine')} engine"
        for zoo in zoos
    )
    headings = {name: heading_by_metric.get(name, name) for name in visible}
    return _listed(
        rows,
        {"name": "controller", "fitness": "fitness", **headings},
        f"{len(rows)} controllers; studies: {counts}",
    )


def _runs(zoo: Zoo, name: ZooName) -> Iterator[JsonObject]:
    """Yield the best run of a model, or the selected ones."""
    columns = zoo.runs(name.model)
    selection = {"": str(zoo.best(name.model)), ALL: "*"}.get(name.run, name.run)
    for run in range(zoo.models[name.model]):
        if fnmatch.fnmatchcase(str(run), selection):
            yield {
                "name": str(ZooName(name.study, name.model, str(run))),
                "study": zoo.study,
                "software": zoo.software,
                **{column: values[run].item() for column, values in columns.items()},
            }


def _listed(rows: list[JsonObject], headings: dict[str, str], remark: str) -> Table:
    """Return the listing; on the screen it has the columns with a heading."""
    table = pd.DataFrame(rows)[[*headings]].map(short)
    table.columns = [*headings.values()]
    table = table.set_index(table.columns[0])
    return Table(rows=rows, views=[table], notes=[remark], data=rows)
