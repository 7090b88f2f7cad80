"""The commands of a program by name: where each is, and in a line what it does.

No command is imported before it is named, so that help is there at once: what a command does is
read from its source.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from typing import Any, cast


class Command:
    """A command: a question, or a dataclass of its options with a method `run`.

    Args:
        place: its module and name, such as `tegotae.questions.verbs:simulate`.
        examples: lines that a user can type, for the end of its help.
    """

    def __init__(self, place: str, *examples: str) -> None:
        self.module, _, self.name = place.partition(":")
        self.examples = examples

    @property
    def summary(self) -> str:
        """The first paragraph of its docstring, read without importing it."""
        spec = find_spec(self.module)
        source = cast(Any, spec).loader.get_source(self.module)
        (definition,) = (
            node
            for node in ast.parse(source).body
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == self.name
        )
        return " ".join((ast.get_docstring(definition) or "").split("\n\n")[0].split())

    def load(self) -> Any:
        """The class, or the question."""
        return getattr(import_module(self.module), self.name)


@dataclass(frozen=True)
class CommandGroup:
    """Commands under a common name."""

    summary: str
    """What they are for."""
    commands: Mapping[str, Command | CommandGroup]
    """Each by its name."""
    sections: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Of a whole program: the names of its commands by purpose."""

    @property
    def examples(self) -> tuple[str, ...]:
        """The first example of its first two commands."""
        return tuple(entry.examples[0] for entry in list(self.commands.values())[:2])
