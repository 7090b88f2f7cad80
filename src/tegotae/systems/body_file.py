"""A body by name: a user's object, or a file (.toml) of a body's numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from tegotae._support import documents
from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.systems.descriptions import describe, restore
from tegotae.systems.user_objects import load_object


def body_called(name: str) -> Body:
    """The body of a name.

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
    try:
        return restore(documents.read(Path(name)), Body, "body")
    except FileNotFoundError:
        raise TegotaeError(f"there is no file {name}") from None
    except TegotaeError as error:
        raise TegotaeError(f"{name} is no body: {error}") from None


def body_text(body: Body, reasons: Mapping[str, str] | None = None) -> str:
    """A body as TOML.

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
