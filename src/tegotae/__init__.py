"""Tegotae: learned feedback in central pattern generators, a thousand rollouts at a time.

Importing it changes nothing of the program that does, and loads nothing: every name is fetched when
it is first used.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

_HOMES = {
    "tegotae._support.errors": ("TegotaeError",),
    "tegotae.parts.bodies": ("Body", "Hopper", "Walker"),
    "tegotae.parts.controller": ("Controller",),
    "tegotae.api.about": ("cite",),
    "tegotae.api.controllers": ("load", "load_all"),
    "tegotae.api.hopping": ("HopperController",),
    "tegotae.api.listing": ("list_models",),
    "tegotae.api.measuring": ("measure",),
    "tegotae.api.training": ("train",),
    "tegotae.api.walking": ("WalkerController",),
    "tegotae.measures.check": ("check",),
    "tegotae.simulation.rollout": ("Rollout", "Timing"),
    "tegotae.simulation.world": ("Scenario",),
    "tegotae.systems.controller_file": ("SavedController", "save"),
    "tegotae.systems.experiment": ("Experiment",),
    "tegotae.systems.registry": ("register",),
    "tegotae.systems.recipe": ("recipe",),
    "tegotae.systems.system": ("System",),
}
_NAMESPACES = {
    "gaits": "tegotae.api.gaits",
    "plot": "tegotae.api.plot",
    "robots": "tegotae_robots.api.robots",
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted({*_HOME_OF, *_NAMESPACES})  # pyright: ignore[reportUnsupportedDunderAll] - it reads the stub


def __getattr__(name: str) -> Any:
    """A public name, a module or the version, when it is first used (PEP 562)."""
    if name in _HOME_OF:
        value = getattr(import_module(_HOME_OF[name]), name)
    elif name in _NAMESPACES:
        value = import_module(_NAMESPACES[name])
    elif name == "__version__":
        value = _version()
    elif not name.startswith("_") and find_spec(f"{__name__}.{name}") is not None:
        return import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", *(name for name in globals() if name[:2] == "__")})


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(__name__)
    except PackageNotFoundError:  # a source tree that is not installed
        return "0+unknown"
