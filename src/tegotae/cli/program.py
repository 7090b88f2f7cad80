"""The commands of a program by name: where each is, and in a line what it does.

No command is imported before it is named, so that help is there at once: what a command does is
read from its source.
"""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from operator import attrgetter
from typing import Any, cast

WIDTH = 80
"""Of all help [columns]."""
_LONGEST = 12
"""Of a name with its summary beside it, where no name is longer."""
SWITCHES: Mapping[str, str] = {
    "--parts FILE": "Load parts of your own, from files or modules, that controller files name.",
    "--quiet": "Print results, warnings and errors only (TEGOTAE_QUIET).",
    "--debug": "Show the source of an error (TEGOTAE_DEBUG).",
    "--version": "Print the version.",
}
"""Options of every command, which may stand anywhere."""


class Command:
    """A command: a question, or a dataclass of its options with a method `run`.

    Args:
        place: its module and name, such as `tegotae.api.plot:surface`.
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
        node: Any = ast.parse(source)
        for part in self.name.split("."):
            kinds = ast.ClassDef | ast.FunctionDef
            (node,) = (x for x in node.body if isinstance(x, kinds) and x.name == part)
        return " ".join((ast.get_docstring(node) or "").split("\n\n")[0].split())

    def load(self) -> Any:
        """Return the class or the function."""
        return attrgetter(self.name)(import_module(self.module))


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
        """The first example of its first two commands; of a program those of the first one."""
        if self.sections:
            return self.commands[next(iter(self.sections.values()))[0]].examples
        return tuple(entry.examples[0] for entry in list(self.commands.values())[:2])


def overview(group: CommandGroup, prog: str) -> str:
    """The commands of a group; of a whole program by purpose, with the options of all of them.

    Args:
        group: of commands.
        prog: the words that name it, such as `tegotae figure`.
    """
    longest = max(_LONGEST, *map(len, group.commands))
    parts = [f"usage: {prog} COMMAND [OPTIONS]\n", *textwrap.wrap(group.summary, WIDTH), ""]
    listed = {
        title: {name: group.commands[name].summary for name in names}
        for title, names in (group.sections or {"": tuple(group.commands)}).items()
    }
    if group.sections:
        listed["With every command"] = dict(SWITCHES)
    for title, entries in listed.items():
        parts += [title] if title else []
        parts += [*(_entry(name, summary, longest) for name, summary in entries.items()), ""]
    parts.append(f"{prog} COMMAND --help explains a command and its options.\n")
    return "\n".join([*parts, examples_text(group.examples)])


def examples_text(examples: Sequence[str]) -> str:
    """The lines about examples at the end of a help text."""
    return "\n".join(["Examples:", *(f"  {example}" for example in examples)]) if examples else ""


def _entry(name: str, summary: str, longest: int) -> str:
    """A name, and its summary beside it."""
    indent = " " * (longest + 4)
    first = f"  {name}".ljust(len(indent))
    return textwrap.fill(summary, WIDTH, initial_indent=first, subsequent_indent=indent)
