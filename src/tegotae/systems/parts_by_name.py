"""Parts by name: a user's object, a body's file (.toml), an oscillator, a terrain in words."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, cast

from tegotae._support import documents
from tegotae._support.errors import TegotaeError, require_known, unknown
from tegotae.parts.bodies import Body
from tegotae.parts.oscillators import Oscillator, oscillator_named
from tegotae.parts.terrains import Terrain
from tegotae.systems.descriptions import describe, restore
from tegotae.systems.registry import is_reference, kinds_of, load_object


def body_called(name: str) -> Body:
    """Return the body of a name.

    Args:
        name: `FILE.toml`, a body as `body_text` writes it; or `FILE.py:OBJECT` or `MODULE:OBJECT`.

    Raises:
        TegotaeError: for a name without a body, or a damaged file.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> _ = open("leg.toml", "w").write(body_text(Hopper(mass_kg=0.2)))
        >>> body_called("leg.toml").mass_kg
        0.2
    """
    if not name.endswith(".toml"):
        return load_object(name, Body, "body")
    return documents.read_as(Path(name), "body", partial(restore, hint=Body, name="body"))


def body_text(body: Body, reasons: Mapping[str, str] | None = None) -> str:
    """Return a body as TOML.

    Args:
        body: a registered one, perhaps in wrappers.
        reasons: comments by the names of numbers.

    Raises:
        TegotaeError: for a body that is not registered.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> body_text(Hopper(), {"mass_kg": "weighed"}).splitlines()[:2]
        ['kind = "Hopper"', 'mass_kg = 0.1  # weighed']
    """
    return "\n".join(_lines(describe(body), "", reasons or {})) + "\n"


def _lines(document: Mapping[str, Any], table: str, reasons: Mapping[str, str]) -> list[str]:
    lines: list[str] = []
    nested: list[str] = []
    for name, value in document.items():
        if isinstance(value, Mapping):
            place, part = f"{table}.{name}".lstrip("."), cast(Mapping[str, Any], value)
            nested += ["", f"[{place}]", *_lines(part, place, reasons)]
        else:
            comment = f"  # {reasons[name]}" if name in reasons else ""
            lines.append(f"{name} = {json.dumps(value)}{comment}")
    return lines + nested


def oscillator_called(name: str) -> Oscillator:
    """Return the oscillator of a name, or a user's own, `FILE.py:OBJECT`."""
    if is_reference(name):
        return load_object(name, Oscillator, "oscillator")
    return oscillator_named(name)


def terrain_of(words: Sequence[str]) -> Terrain:
    """Return the ground that a text names: its kind, and numbers of it.

    Raises:
        TegotaeError: for a kind or a number that there is not.

    Example:
        >>> terrain_of(["slope", "along=0.1"])
        Slope(along=0.1, across=0.0)
    """
    kind, numbers = words[0], assignments("--terrain", words[1:])
    if is_reference(kind):
        terrain = load_object(kind, Terrain, "terrain")
    else:
        terrains = {
            name.lower(): terrain_class for name, terrain_class in kinds_of(Terrain).items()
        }
        if kind.lower() not in terrains:
            raise unknown("terrain", kind, terrains)
        terrain = terrains[kind.lower()]()  # pyright: ignore[reportAbstractUsage] - no abstract one is known
    names = [field.name for field in dataclasses.fields(terrain)]  # type: ignore[arg-type]
    for name in numbers:
        require_known(f"number of the terrain {kind}", name, names)
    return dataclasses.replace(terrain, **numbers)  # type: ignore[type-var]


def assignments(option: str, texts: Iterable[str]) -> dict[str, float]:
    """Parse names and numbers, each name once.

    Args:
        option: that the texts are of, for errors.
        texts: NAME=NUMBER each.
    """
    values: dict[str, float] = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            raise TegotaeError(f"{option} {text} sets nothing; write NAME=NUMBER") from None
        if name in values:
            raise TegotaeError(f"{option} names {name} twice; give it one value")
        values[name] = number
    return values
