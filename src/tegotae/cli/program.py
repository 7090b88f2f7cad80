"""The commands of a program by name: the place of each, and its summary.

No command is imported before it is named, so that help is there at once: a summary is read from
the source.
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
"""Width of all help [columns]."""
_LONGEST = 12
"""Letters of a name that leave room for its summary beside it."""
SWITCHES: Mapping[str, str] = {
    "--parts FILE": "Load your own parts, which controller files name, from files or modules.",
    "--quiet": "Print results, warnings and errors only (TEGOTAE_QUIET).",
    "--debug": "Show the source of an error (TEGOTAE_DEBUG).",
    "--version": "Print the version.",
}
"""Options of every command, which may stand anywhere."""


class Command:
    """Command: a function with a result, or a dataclass of options with a method `run`.

    Args:
        place: its module and name, such as `tegotae.api.plot:surface`.
        examples: lines that a user can type, for the end of its help.
        subjects: words after the command for each kind of subject, by heading, whose options
            differ; under "" where there is one kind.
        names: names of the subjects where none is given.
        out: name of the file or the folder that is written if no other output is named, in which
            {name} is that of the subject.
        pictures: False if its result has no figure.
    """

    def __init__(
        self,
        place: str,
        *examples: str,
        subjects: Mapping[str, str] | None = None,
        names: Sequence[str] = (),
        out: str = "",
        pictures: bool = True,
    ) -> None:
        self.module, _, self.name = place.partition(":")
        self.examples, self.subjects = examples, subjects or {}
        self.names, self.out, self.pictures = (*names,), out, pictures

    @property
    def summary(self) -> str:
        """First paragraph of the docstring, read without importing the function."""
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
    """Purpose of the commands."""
    commands: Mapping[str, Command | CommandGroup]
    """Commands and groups by name."""
    sections: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Names of the commands by purpose, of a whole program."""

    @property
    def examples(self) -> tuple[str, ...]:
        """First examples of the first two commands; for a program those of the first one."""
        if self.sections:
            return self.commands[next(iter(self.sections.values()))[0]].examples
        return tuple(entry.examples[0] for entry in list(self.commands.values())[:2])


def overview(group: CommandGroup, prog: str) -> str:
    """Return the list of the commands of a group; of a whole program by purpose.

    Args:
        group: the commands.
        prog: words that name it, such as `tegotae figure`.
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
    """Return the lines about examples at the end of a help text."""
    return "\n".join(["Examples:", *(f"  {example}" for example in examples)]) if examples else ""


def _entry(name: str, summary: str, longest: int) -> str:
    """Return a name, and its summary beside it."""
    indent = " " * (longest + 4)
    first = f"  {name}".ljust(len(indent))
    return textwrap.fill(summary, WIDTH, initial_indent=first, subsequent_indent=indent)
