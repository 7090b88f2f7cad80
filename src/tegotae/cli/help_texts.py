"""The lists of commands by purpose: only names and first lines are read, so that they are there at
once."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from tegotae.cli.program import CommandGroup

WIDTH = 80
"""Of all help [columns]."""
_INDENT = 16
SWITCHES: Mapping[str, str] = {
    "--parts FILE": "Load parts of your own, from files or modules, that controller files name.",
    "--quiet": "Print results, warnings and errors only (TEGOTAE_QUIET).",
    "--debug": "Show the source of an error (TEGOTAE_DEBUG).",
    "--version": "Print the version.",
}
"""Options of every command, which may stand anywhere."""


def overview(program: CommandGroup, prog: str) -> str:
    """All commands in groups by purpose, the options of every command, and two examples."""
    usage = f"usage: {prog} COMMAND [OPTIONS]\n"
    parts = [usage, *textwrap.wrap(program.summary, WIDTH), ""]
    for title, names in program.sections.items():
        parts.append(title)
        parts += [_entry(name, program.commands[name].summary) for name in names]
        parts.append("")
    parts.append("With every command")
    parts += [_entry(switch, about) for switch, about in SWITCHES.items()]
    parts.append("")
    parts.append(f"{prog} COMMAND --help explains a command and its options.\n")
    parts.append(examples_text(program.commands[next(iter(program.sections.values()))[0]].examples))
    return "\n".join(parts)


def overview_of(name: str, group: CommandGroup) -> str:
    """The commands of a group.

    Args:
        name: of the group, such as `tegotae figure`.
        group: of that name.
    """
    longest = max(_INDENT - 4, *map(len, group.commands))
    return "\n".join(
        [
            f"usage: {name} COMMAND [OPTIONS]\n",
            *textwrap.wrap(group.summary, WIDTH),
            "",
            *(_entry(each, entry.summary, longest) for each, entry in group.commands.items()),
            "",
            f"{name} COMMAND --help explains a command and its options.\n",
            examples_text(group.examples),
        ]
    )


def examples_text(examples: Sequence[str]) -> str:
    """The lines about examples at the end of a help text."""
    return "\n".join(["Examples:", *(f"  {example}" for example in examples)]) if examples else ""


def _entry(name: str, summary: str, longest: int = _INDENT - 4) -> str:
    """A name, and its summary beside it; below it of a longer name than `longest`."""
    first, indent = f"  {name}", " " * (longest + 4)
    beside = len(name) <= longest
    text = textwrap.fill(
        summary,
        WIDTH,
        initial_indent=first.ljust(len(indent)) if beside else indent,
        subsequent_indent=indent,
    )
    return text if beside else f"{first}\n{text}"
