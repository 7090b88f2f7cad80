"""What `tegotae --help` prints: the commands by purpose, and examples after the help of each.

Of commands only names and first lines are read, so that the list is there at once.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping

from tegotae.cli.commands import COMMANDS, SECTIONS, Command, CommandGroup

WIDTH = 80
"""Of the list of commands [columns]."""
_INDENT = 16

SWITCHES: Mapping[str, str] = {
    "--parts FILE": "Load parts of your own from files or modules; needed where a file names them.",
    "--quiet": "Leave out progress and notes: print results, warnings and errors (TEGOTAE_QUIET).",
    "--debug": "Show the source of an error (TEGOTAE_DEBUG).",
    "--version": "Print the version.",
}
"""Options of every command, which may stand anywhere."""

ABOUT = "Train, simulate and compare learned Tegotae feedback in central pattern generators."


def overview() -> str:
    """All commands in groups by purpose, the options of every command, and two examples."""
    parts = ["usage: tegotae COMMAND [OPTIONS]\n", *textwrap.wrap(ABOUT, WIDTH), ""]
    for title, names in SECTIONS.items():
        parts.append(title)
        parts += [_entry(name, COMMANDS[name].summary) for name in names]
        parts.append("")
    parts.append("With every command")
    parts += [_entry(switch, about) for switch, about in SWITCHES.items()]
    parts.append("")
    parts.append("tegotae COMMAND --help explains a command and its options.\n")
    parts += examples_of(COMMANDS["simulate"])
    return "\n".join(parts)


def overview_of(name: str, group: CommandGroup) -> str:
    """The commands of a group.

    Args:
        name: of the group, such as `tegotae figure`.
        group: of that name.
    """
    return "\n".join(
        [
            f"usage: {name} COMMAND [OPTIONS]\n",
            *textwrap.wrap(group.summary, WIDTH),
            "",
            *(_entry(each, entry.summary) for each, entry in group.commands.items()),
            "",
            f"{name} COMMAND --help explains a command and its options.\n",
            *examples_of(group),
        ]
    )


def examples_of(entry: Command | CommandGroup) -> Iterator[str]:
    """The lines about examples at the end of a command's help."""
    yield "Examples:"
    yield from (f"  {example}" for example in entry.examples)


def _entry(name: str, summary: str) -> str:
    return textwrap.fill(
        summary,
        WIDTH,
        initial_indent=f"  {name}".ljust(_INDENT - 2) + "  ",
        subsequent_indent=" " * _INDENT,
    )
