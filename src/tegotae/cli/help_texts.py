"""The texts of --help: the commands by purpose, and each command's options with two examples.

For the list of commands only names and first lines are read, so that it is there at once.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping

from tegotae.cli.program import Command, CommandGroup

WIDTH = 80
"""Of all help [columns]."""
_INDENT = 16
_LONGEST = 20
"""Of an option that has its meaning in the same line [columns]."""

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
    parts += examples_of(program.commands[next(iter(program.sections.values()))[0]])
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
            *examples_of(group),
        ]
    )


def help_of(name: str, command: Command) -> str:
    """The help of a command: purpose, arguments, options by their groups, and examples.

    Args:
        name: of the command, such as `tegotae figure surface`.
        command: of that name.
    """
    from tegotae.cli.parsing import description_of, options_of  # slow to import

    own = command.load()
    options = options_of(own)
    needed = [each.shown for each in options if each.required or not each.names]
    usage = " ".join([f"usage: {name}", *needed, "[OPTIONS]"])
    parts = [textwrap.fill(usage, WIDTH, subsequent_indent=" " * 6), ""]
    for paragraph in description_of(own).split("\n\n"):
        parts += [textwrap.fill(" ".join(paragraph.split()), WIDTH), ""]
    groups = dict.fromkeys(each.group for each in options)
    for group in sorted(groups, key=lambda each: (each != "", each != "Options")):
        parts += [group] if group else []
        parts += [
            _entry(each.shown, each.meaning, _LONGEST) for each in options if each.group == group
        ]
        parts.append("")
    return "\n".join([*parts, *examples_of(command)])


def examples_of(entry: Command | CommandGroup) -> Iterator[str]:
    """The lines about examples at the end of a command's help."""
    yield "Examples:"
    yield from (f"  {example}" for example in entry.examples)


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
