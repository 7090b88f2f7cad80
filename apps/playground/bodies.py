"""The bodies of a page: what it draws, changes and releases."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from tegotae._support.documents import Json, JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.measures.gaits.names import leg_names
from tegotae.parts.bodies import (
    Bar,
    Body,
    Hopper,
    Plate,
)
from tegotae.parts.bodies.upright import Upright

STANDARD: dict[str, Body] = {
    "hopper": Hopper(),
    "bar": Bar(inertia_ratio=0.6, present=(1.0, 1.0)),
    "quadruped": Plate(
        pitch_inertia_ratio=0.6, roll_inertia_ratio=1.6, present=(1.0, 1.0, 1.0, 1.0)
    ),
}
"""The bodies that every page has: each a frame on the paper's legs."""


@dataclass(frozen=True)
class Shown:
    """A body as a page has it.

    Args:
        name: what it is called there.
        body: the body, with the numbers that the page begins with.

    Raises:
        TegotaeError: for a body that a page cannot draw.
    """

    name: str
    body: Body

    def __post_init__(self) -> None:
        hopper = isinstance(self.body, Hopper) and self.body.is_linear
        if not (hopper or isinstance(self.body, Upright)):
            raise TegotaeError(
                f"a playground shows hoppers, bars and plates on linear springs; it cannot draw a "
                f"{type(self.body).__name__}"
            )

    def document(self, pose_names: tuple[str, ...], numbers: Mapping[str, Json]) -> JsonObject:
        """Return the description of the body for a page."""
        body = self.body
        turns = body.turns if isinstance(body, Upright) else ()
        ratios = {"pitch": "pitch_inertia_ratio", "roll": "roll_inertia_ratio"}
        if isinstance(body, Bar):
            ratios = {"pitch": "inertia_ratio"}
        return {
            "name": self.name,
            "kind": type(body).__name__,
            "limbs": body.limbs,
            "legs": list(leg_names(body)) if isinstance(body, Upright) else [""],
            "hips": places(body),
            "turns": [
                {
                    "name": turn.name,
                    "arms_m": list(turn.arms_m),
                    "reach_m": turn.reach_m,
                    "ratio": ratios.get(turn.name, f"{turn.name}_inertia_ratio"),
                }
                for turn in turns
            ],
            "numbers": {name: x for name, x in numbers.items() if name != "present"},
            "pose_names": list(pose_names),
        }


def places(body: Body) -> list[list[float]]:
    """Return the positions of the hips: forward, and to the left [m]."""
    if isinstance(body, Bar):
        return [[x, 0.0] for x in body.hips_m]
    if isinstance(body, Plate):
        return [list(pair) for pair in zip(body.hips_x_m, body.hips_z_m, strict=True)]
    return [[0.0, 0.0]]


def of_same_form(a: Body, b: Body) -> bool:
    """Return whether two bodies differ in numbers alone that a page can change."""
    return form(a) == form(b)


def losing_legs(body: Body) -> Body:
    """Return the body, with legs that can be lost if it has several."""
    if isinstance(body, Upright) and body.present is None:
        return dataclasses.replace(body, present=(1.0,) * body.limbs)
    return body


def form(body: Body) -> JsonObject:
    """Return the part of a body that is no data of an engine: its kind, its hips, its absent
    legs."""
    fields = vars(body)
    fixed = {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in fields.items()
        if not isinstance(value, (int, float)) and name != "present"
    }
    return {"kind": type(body).__name__, "loses_legs": bool(fields.get("present")), **fixed}
