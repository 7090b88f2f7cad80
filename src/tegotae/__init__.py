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
    "tegotae.measures.evaluation": ("Protocol",),
    "tegotae.measures.objectives.fitness": ("Fitness",),
    "tegotae.parts.bodies": ("Bar", "Body", "Hopper", "Walker"),
    "tegotae.parts.controller": ("Controller", "Tegotae"),
    "tegotae.questions.about": ("cite",),
    "tegotae.questions.drawing": (
        "figure_basin",
        "figure_learning_curves",
        "figure_phase_locking",
        "figure_phase_response",
        "figure_poincare",
        "figure_portrait",
        "figure_surface",
    ),
    "tegotae.questions.explaining": ("explain",),
    "tegotae.questions.gaits": (
        "gait_front",
        "gait_lesion",
        "gait_map",
        "gait_stability",
        "gait_sweep",
    ),
    "tegotae.questions.generalising": ("generalise",),
    "tegotae.questions.listing": ("models",),
    "tegotae.questions.measuring": ("measure",),
    "tegotae.questions.training": ("train",),
    "tegotae.questions.verbs": ("compare", "evaluate", "simulate"),
    "tegotae.questions.wiring": ("wiring_baseline",),
    "tegotae.simulation.checks": (
        "check_body",
        "check_controller",
        "check_oscillator",
        "check_term",
    ),
    "tegotae.simulation.rollout": ("Engine", "Timing", "Trajectory"),
    "tegotae.simulation.world": ("Scenario", "Step"),
    "tegotae.systems.controller_file": ("ControllerSet", "SavedController", "load", "save"),
    "tegotae.systems.experiment": ("Experiment",),
    "tegotae.systems.legged": ("Legged",),
    "tegotae.systems.models": ("Model", "all_models", "build", "find"),
    "tegotae.systems.registry": ("register",),
    "tegotae.systems.system": ("Release", "System"),
    "tegotae_robots.questions.benchmark": ("benchmark_run",),
    "tegotae_robots.questions.exporting": ("export_c", "export_cost", "export_native"),
    "tegotae_robots.questions.identifying": ("identify",),
    "tegotae_robots.questions.suggesting_wirings": ("wiring_suggest",),
    "tegotae_robots.questions.template": ("template",),
    "tegotae_robots.questions.transfer": ("wiring_transfer",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)  # pyright: ignore[reportUnsupportedDunderAll] - it reads the stub


def __getattr__(name: str) -> Any:
    """A public name, a module or the version, when it is first used (PEP 562)."""
    if name in _HOME_OF:
        value = getattr(import_module(_HOME_OF[name]), name)
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
