"""Legged systems by name, or of a user's own file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

from tegotae import controller_file
from tegotae.bodies import Bar
from tegotae.errors import TegotaeError, unknown
from tegotae.gaits.legged import Legged
from tegotae.models import build
from tegotae.references import is_reference, named


def _bar(inertia_ratio: float, about: str) -> Callable[[], Legged]:
    def made() -> Legged:
        return Legged(
            about=about,
            body=Bar(inertia_ratio=inertia_ratio),
            controller=dataclasses.replace(build("V-sector-w8"), limbs=2),
            weights=(1.0,),
            omega=8.0,
        )

    return made


SYSTEMS: dict[str, Callable[[], Legged]] = {
    "bar-light": _bar(0.6, "two hopper legs under a bar that is light in pitch, j = 0.6"),
    "bar-heavy": _bar(1.6, "two hopper legs under a bar that is heavy in pitch, j = 1.6"),
}
"""What makes each of the named systems."""


def system(name: str) -> Legged:
    """A legged system.

    Args:
        name: of `SYSTEMS`; `FILE.py:OBJECT` or `MODULE:OBJECT`, a `Legged`; or a controller's file
            (.json) of `tegotae train`, whose body has several legs.

    Raises:
        TegotaeError: for an unknown name, an object of another kind, or a body of one leg.

    Example:
        >>> system("bar-light").body.inertia_ratio
        0.6
    """
    if name in SYSTEMS:
        return SYSTEMS[name]()
    if is_reference(name):
        return named(name, Legged, "legged system")
    if name.endswith(".json"):
        saved = controller_file.load(Path(name))
        return Legged(
            about=saved.model or Path(name).stem,
            body=saved.body,
            controller=saved.controller,
            weights=tuple(saved.weights.tolist()),
            omega=saved.omega,
        )
    error = unknown("legged system", name, SYSTEMS)
    raise TegotaeError(f"{error}; FILE.py:OBJECT names one of your own")
