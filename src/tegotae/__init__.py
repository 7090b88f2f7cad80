"""Tegotae: learned feedback in central pattern generators, a thousand rollouts at a time.

Importing it changes nothing of the program that does, and loads nothing: every name is fetched when
it is first used.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tegotae._support.errors import TegotaeError
    from tegotae.measures.evaluation import Protocol
    from tegotae.measures.objectives.fitness import Fitness
    from tegotae.parts.bodies import Bar, Body, Hopper, Walker
    from tegotae.parts.controller import Controller, Tegotae
    from tegotae.questions.drawing import (
        figure_basin,
        figure_learning_curves,
        figure_phase_locking,
        figure_phase_response,
        figure_poincare,
        figure_portrait,
        figure_surface,
    )
    from tegotae.questions.exporting import export_c, export_cost, export_native
    from tegotae.questions.gaits import (
        gait_front,
        gait_lesion,
        gait_map,
        gait_stability,
        gait_sweep,
    )
    from tegotae.questions.listing import models
    from tegotae.questions.training import train
    from tegotae.questions.verbs import compare, evaluate, generalise, measure, simulate
    from tegotae.questions.wiring import wiring_baseline, wiring_suggest
    from tegotae.simulation.checks import (
        check_body,
        check_controller,
        check_oscillator,
        check_term,
    )
    from tegotae.simulation.rollout import Engine, Timing, Trajectory
    from tegotae.simulation.world import Scenario, Step
    from tegotae.systems.controller_file import ControllerSet, SavedController, load, save
    from tegotae.systems.experiment import Experiment
    from tegotae.systems.legged import Legged
    from tegotae.systems.models import Model, all_models, build, find
    from tegotae.systems.registry import register
    from tegotae.systems.system import Release, System

    __version__: str

_HOMES = {
    "_support.errors": ("TegotaeError",),
    "measures.evaluation": ("Protocol",),
    "measures.objectives.fitness": ("Fitness",),
    "parts.bodies": ("Bar", "Body", "Hopper", "Walker"),
    "parts.controller": ("Controller", "Tegotae"),
    "questions.drawing": (
        "figure_basin",
        "figure_learning_curves",
        "figure_phase_locking",
        "figure_phase_response",
        "figure_poincare",
        "figure_portrait",
        "figure_surface",
    ),
    "questions.exporting": ("export_c", "export_cost", "export_native"),
    "questions.gaits": (
        "gait_front",
        "gait_lesion",
        "gait_map",
        "gait_stability",
        "gait_sweep",
    ),
    "questions.listing": ("models",),
    "questions.training": ("train",),
    "questions.verbs": ("compare", "evaluate", "generalise", "measure", "simulate"),
    "questions.wiring": ("wiring_baseline", "wiring_suggest"),
    "simulation.checks": ("check_body", "check_controller", "check_oscillator", "check_term"),
    "simulation.rollout": ("Engine", "Timing", "Trajectory"),
    "simulation.world": ("Scenario", "Step"),
    "systems.controller_file": ("ControllerSet", "SavedController", "load", "save"),
    "systems.experiment": ("Experiment",),
    "systems.legged": ("Legged",),
    "systems.models": ("Model", "all_models", "build", "find"),
    "systems.registry": ("register",),
    "systems.system": ("Release", "System"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Bar",
    "Body",
    "Controller",
    "ControllerSet",
    "Engine",
    "Experiment",
    "Fitness",
    "Hopper",
    "Legged",
    "Model",
    "Protocol",
    "Release",
    "SavedController",
    "Scenario",
    "Step",
    "System",
    "Tegotae",
    "TegotaeError",
    "Timing",
    "Trajectory",
    "Walker",
    "all_models",
    "build",
    "check_body",
    "check_controller",
    "check_oscillator",
    "check_term",
    "compare",
    "evaluate",
    "export_c",
    "export_cost",
    "export_native",
    "figure_basin",
    "figure_learning_curves",
    "figure_phase_locking",
    "figure_phase_response",
    "figure_poincare",
    "figure_portrait",
    "figure_surface",
    "find",
    "gait_front",
    "gait_lesion",
    "gait_map",
    "gait_stability",
    "gait_sweep",
    "generalise",
    "load",
    "measure",
    "models",
    "register",
    "save",
    "simulate",
    "train",
    "wiring_baseline",
    "wiring_suggest",
]


def __getattr__(name: str) -> Any:
    """A public name, a module or the version, when it is first used (PEP 562)."""
    if name in _HOME_OF:
        found = getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)
    elif name == "__version__":
        found = _version()
    elif not name.startswith("_") and find_spec(f"{__name__}.{name}") is not None:
        return import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(__name__)
    except PackageNotFoundError:  # a source tree that is not installed
        return "0+unknown"
