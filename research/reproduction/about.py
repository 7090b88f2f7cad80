"""Description of a study in two sentences: its scale, and its reading of what the paper omits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from research.reproduction.readings.designs import selecting_body
from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body, Hopper
from tegotae.systems.descriptions import document_path, restore
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import study_recipes

_VALUES = {
    document_path(Experiment, path): words
    for path, words in (
        ("system.body.mass_kg", "a hopper of {:.3g} kg"),
        ("system.body.rest_length_m", "a leg of {:.3g} m"),
        ("system.body.stiffness_n_per_m", "{:.3g} N/m"),
        ("system.body.damping_ns_per_m", "{:.3g} N s/m in stance"),
        ("system.body.flight_damping_ns_per_m", "{:.3g} in flight"),
        ("system.body.max_force_n", "at most {:.3g} N"),
        ("system.release.height_m", "released at {:.3g} m"),
        ("protocol.drop_m", "a drop of {:.3g} m"),
        ("protocol.work", "{} work"),
        ("objective.frequency_weight", "ΔΩ weighs {:.3g}"),
    )
}
"""Entries of a reading's description, in this order, by their paths in the document of an
experiment."""


def study_summary(document: Mapping[str, Any], models: int) -> str:
    """Return the description of a study's folder.

    Args:
        document: the description of the study, `research.reproduction.folder.Folder.document`.
        models: how many models have a record.

    Returns:
        A sentence on the scale; one on the reading, as far as all experiments share it.

    Examples:
        >>> algorithm = {"name": "pgpe", "population": 32}
        >>> of = {"scale": "quick", "seeds": 5, "algorithm": algorithm, "experiments": {}}
        >>> study_summary(of | {"stopping": {"generations": 480}}, 8)
        'Scale quick: 8 models, 5 runs each, by pgpe with 32 episodes a generation, at most 480 generations.'
    """  # noqa: E501
    scale = (
        f"Scale {document['scale']}: {models} models, {document['seeds']} runs each, by "
        f"{document['algorithm']['name']} with {document['algorithm']['population']} episodes a "
        f"generation, at most {document['stopping']['generations']} generations."
    )
    return " ".join(filter(None, (scale, _reading([*document["experiments"].values()]))))


def _reading(experiments: list[Mapping[str, Any]]) -> str:
    """Return a sentence on the reading: its name, and the values that all experiments share."""
    shared = {}
    for place, words in _VALUES.items():
        values = [_entry(experiment, place) for experiment in experiments]
        if values and values[0] is not None and all(value == values[0] for value in values):
            shared[place] = values[0], words
    if not any(place.startswith("system.body") for place in shared):
        return ""
    settings = ", ".join(words.format(value) for value, words in shared.values())
    name = _name(experiments[0], {place: value for place, (value, _) in shared.items()})
    return f"{name}: {settings}."


def _name(experiment: Mapping[str, Any], shared: Mapping[str, Any]) -> str:
    standard = study_recipes()["V-sector-w4"].experiment().document
    if len(shared) == len(_VALUES) and all(
        _entry(standard, path) == shared[path] for path in shared
    ):
        return "The study's own reading"
    try:
        body = restore(experiment["system"]["body"], Body, "body")
    except TegotaeError:
        body = None
    if not isinstance(body, Hopper) or not selecting_body(body):
        return "A reading of its own"
    against = " (damped in flight, though III-B of the paper switches that off)"
    return "A calibrated reading" + against * bool(body.flight_damping_ns_per_m)


def _entry(document: Any, place: str) -> Any:
    """Return an entry of a nested document, or None if there is none."""
    for key in place.split("."):
        document = document.get(key) if isinstance(document, Mapping) else None
    return document
