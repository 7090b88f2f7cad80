"""What a study is of, in two sentences: its scale, and the body that all of its models have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_OF_BODY = (
    ("mass_kg", "{:.3g} kg"),
    ("rest_length_m", "a leg of {:.3g} m"),
    ("stiffness_n_per_m", "{:.3g} N/m"),
    ("damping_ns_per_m", "{:.3g} N s/m"),
    ("max_force_n", "at most {:.3g} N"),
)
"""What is said of a hopper, in this order, by the key in its document."""


def about(document: Mapping[str, Any], models: int) -> str:
    """What a study's folder holds.

    Args:
        document: the description of the study, `reproduction.folder.Folder.document`.
        models: how many models have a record.

    Returns:
        A sentence on the scale; one on the body, if all experiments have the same hopper.

    Examples:
        >>> algorithm = {"name": "pgpe", "population": 32}
        >>> of = {"scale": "quick", "seeds": 5, "algorithm": algorithm, "experiments": {}}
        >>> about(of | {"stopping": {"generations": 480}}, 8)
        'Scale quick: 8 models, 5 runs each, by pgpe with 32 episodes a generation, at most 480 generations.'
    """  # noqa: E501
    scale = (
        f"Scale {document['scale']}: {models} models, {document['seeds']} runs each, by "
        f"{document['algorithm']['name']} with {document['algorithm']['population']} episodes a "
        f"generation, at most {document['stopping']['generations']} generations."
    )
    return " ".join(filter(None, (scale, _body([*document["experiments"].values()]))))


def _body(experiments: list[Mapping[str, Any]]) -> str:
    bodies = [e.get("system", {}).get("body") for e in experiments]
    if not bodies or any(body != bodies[0] for body in bodies):
        return ""
    body = bodies[0]
    if not isinstance(body, Mapping) or any(key not in body for key, _ in _OF_BODY):
        return ""
    return f"The hopper: {', '.join(words.format(body[key]) for key, words in _OF_BODY)}."
