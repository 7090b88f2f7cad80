"""All commands by name: where each is, and in a line what it does.

No command is imported before it is named, so that help is there at once: what a command does is
read from its source.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, cast


@dataclass(frozen=True)
class Command:
    """A command: a dataclass of its options, with a method `run`."""

    module: str
    """Its module in `tegotae.cli`."""
    name: str
    """Its class."""

    @property
    def summary(self) -> str:
        """The first paragraph of the class's docstring, read without importing it."""
        spec = find_spec(self._path)
        source = cast(Any, spec).loader.get_source(self._path)
        (own,) = (
            node
            for node in ast.parse(source).body
            if isinstance(node, ast.ClassDef) and node.name == self.name
        )
        return " ".join((ast.get_docstring(own) or "").split("\n\n")[0].split())

    def load(self) -> type:
        """The class."""
        return getattr(import_module(self._path), self.name)

    @property
    def _path(self) -> str:
        return f"tegotae.cli.{self.module}"


@dataclass(frozen=True)
class CommandGroup:
    """Commands under a common name."""

    summary: str
    """What they are for."""
    commands: Mapping[str, Command | CommandGroup]
    """Each by its name."""


def in_name_only(entry: Command | CommandGroup) -> Callable[[], Any]:
    """A stand-in with an entry's summary and without options, for a list of commands."""

    def stand_in() -> None:
        raise AssertionError(f"a stand-in was run: {entry.summary}")

    stand_in.__doc__ = entry.summary
    return stand_in


COMMANDS: Mapping[str, Command | CommandGroup] = {
    "models": Command("models", "Models"),
    "train": Command("train", "Train"),
    "tune": Command("tune", "Tune"),
    "simulate": Command("simulate", "Simulate"),
    "evaluate": Command("evaluate", "Evaluate"),
    "compare": Command("compare", "Compare"),
    "measure": Command("measure", "Measure"),
    "figure": CommandGroup(
        "Draw a picture that explains a controller, with its numbers beside it.",
        {
            "gain-map": Command("figure.gain_map", "GainMap"),
            "surface": Command("figure.surface", "SurfaceFigure"),
            "portrait": Command("figure.portrait", "Portrait"),
            "phase-locking": Command("figure.phase_locking", "PhaseLocking"),
            "phase-response": Command("figure.phase_response", "PhaseResponseFigure"),
            "basin": Command("figure.basin", "Basin"),
            "poincare": Command("figure.poincare", "PoincareFigure"),
            "learning-curves": Command("figure.learning_curves", "LearningCurves"),
            "optimum": Command("figure.optimum", "Optimum"),
        },
    ),
    "gait": CommandGroup(
        "Study the gaits of a body with several legs.",
        {
            "sweep": Command("gait.sweep", "Sweep"),
            "map": Command("gait.map", "Map"),
            "stability": Command("gait.stability", "Stability"),
            "lesion": Command("gait.lesion", "Lesion"),
        },
    ),
    "generalise": Command("generalise", "Generalise"),
    "study": CommandGroup(
        "Run the whole study of the paper, and report on it.",
        {
            "run": Command("study", "StudyRun"),
            "status": Command("study", "StudyStatus"),
            "report": Command("study", "StudyReport"),
            "export": Command("study", "StudyExport"),
            "figures": Command("study", "StudyFigures"),
            "merge": Command("study", "StudyMerge"),
            "multiverse": CommandGroup(
                "Judge the claims over what the paper leaves open: body, work, release, budgets.",
                {
                    "run": Command("multiverse", "MultiverseRun"),
                    "status": Command("multiverse", "MultiverseStatus"),
                    "export": Command("multiverse", "MultiverseExport"),
                    "figures": Command("multiverse", "MultiverseFigures"),
                },
            ),
        },
    ),
    "export": CommandGroup(
        "Take a controller to a robot.",
        {
            "c": Command("export.c", "ExportC"),
            "cost": Command("export.cost", "ExportCost"),
        },
    ),
    "playground": Command("playground", "Playground"),
    "bench": Command("bench", "Bench"),
    "cite": Command("cite", "Cite"),
}

MOVED: Mapping[str, str] = {
    "train-env": "train MODEL --env ENV",
    "gait simulate": "simulate",
    "gait basin": "figure basin",
    "gait judge": "evaluate",
}
"""Commands that went, and which one answers their question now."""
