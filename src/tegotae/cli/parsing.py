"""Words of the command line to commands and options, and their help."""

from __future__ import annotations

import contextlib
import io
import os
import re
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import tyro

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import number, whole_number
from tegotae.cli.program import Command, CommandGroup

_CONFIG = (
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
    tyro.conf.PositionalMetavarFromFieldName,
)


def parse(words: Sequence[str], entry: Command | CommandGroup, prog: str) -> Any:
    """The command that words make, with its options.

    Args:
        words: the options of a command; of a group, words that begin with none of its commands.
        entry: the command or the group.
        prog: the words before.

    Raises:
        TegotaeError: for words that do not make a command.
    """
    if isinstance(entry, CommandGroup):
        listed = ", ".join(entry.commands)
        given = f"{prog} has no option {words[0]!r}" if words else "no command is given"
        raise TegotaeError(f"{given}; {prog} takes one of {listed}, or --help")
    command = entry.load()
    takes = {name for each in options_of(command) if each.value for name in each.names}
    for word, after in pairwise((*words, "--")):
        if word in takes and after.startswith("--"):
            raise TegotaeError(f"{word} has no value; see {prog} --help")
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box), _wide():
            return tyro.cli(command, prog=prog, args=list(words), config=_CONFIG, registry=_NUMBERS)
    except SystemExit:
        raise TegotaeError(f"{_said(box.getvalue(), prog)}; see {prog} --help") from None


@contextlib.contextmanager
def _wide() -> Iterator[None]:
    """A terminal so wide that no line of an error is broken."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "100000"
    try:
        yield
    finally:
        del os.environ["COLUMNS"]
        if before is not None:
            os.environ["COLUMNS"] = before


def _said(box: str, prog: str) -> str:
    """What tyro says in a box of several paragraphs, in one line."""
    lines = re.sub(r"\x1b\[[\d;]*m", "", box).splitlines()[1:]
    lines = ["" if set(line) <= set("╰─╯│- ") else line[2:].rstrip("│ ") for line in lines]
    text = "\n".join(lines).partition("For full helptext")[0].strip("\n")
    named = re.findall(r"^ {4}(\S.*)", text, re.MULTILINE)
    first = " ".join(text.partition("\n\n")[0].split()).rstrip(".")
    if first.startswith("Missing from"):
        return f"{prog} needs {', '.join(named)}"
    if wrong := re.match(r"Error parsing (\S+): (.*)", first):
        given = re.search(r"\['(.*)'\]", wrong[2])  # as Python would write them
        words = given and given[1].replace("', '", " ")
        return f"{wrong[1]} is {words!r}; write {named[0]}" if words else f"{wrong[1]}: {wrong[2]}"
    return f"{first}; perhaps you meant {', '.join(named)}" if named else first


_NUMBERS = tyro.constructors.ConstructorRegistry()


@_NUMBERS.primitive_rule
def _number(
    info: tyro.constructors.PrimitiveTypeInfo,
) -> tyro.constructors.PrimitiveConstructorSpec | None:
    """Read numbers as tables do (`tegotae._support.tables.number`)."""
    readers = {float: number, int: whole_number}
    if info.type not in readers:
        return None
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=info.type.__name__.upper(),
        instance_from_str=lambda words: readers[info.type](words[0]),
        is_instance=lambda value: isinstance(value, (int, info.type)),
        str_from_instance=lambda value: [str(value)],
    )


@dataclass(frozen=True)
class Option:
    """An option of a command, or an argument without a name."""

    names: tuple[str, ...]
    """Such as `--out`; none for an argument."""
    value: str
    """Its value in capitals, such as PATH; of an argument its name; none of a switch."""
    meaning: str
    """In one paragraph, with the default."""
    required: bool
    """Whether the command refuses to run without it."""
    group: str
    """Heading in the help."""

    @property
    def shown(self) -> str:
        """Its name and value."""
        return " ".join(filter(None, [", ".join(self.names), self.value]))


def options_of(command: type) -> tuple[Option, ...]:
    """The arguments and options of a command, as its help shows them.

    A class of shared options may name their heading, `HEADING`.
    """
    # The class is the kind of an action, in tyro's own copy of argparse.
    actions = (a for a in _parser(command)._actions if type(a).__name__ != "_HelpAction")
    return tuple(_option(command, action) for action in actions)


def description_of(command: type) -> str:
    """The docstring of a command."""
    return _parser(command).description or ""


def _option(command: type, action: Any) -> Option:
    value = action.metavar or ""
    if value.startswith("{"):
        value = value.strip("{}").replace(",", "|")
    if not action.option_strings and action.nargs == "*":
        value = f"[{value.strip('[]')} ...]"
    more = re.fullmatch(r"\[(\w+) \[\1 \.\.\.\]\]", value)
    meaning = " ".join((action.help or "").replace("%%", "%").split())
    unsaid = r" ?\(default: (False)?\)" + ("" if action.option_strings else r"| \(required\)")
    field = action.dest.replace("-", "_")
    return Option(
        names=tuple(each for each in action.option_strings if each.startswith("--")),
        value=f"{more[1]} ..." if more else value,
        meaning=re.sub(unsaid, "", meaning),
        required="(required)" in meaning,
        group=_group(command, field) if action.option_strings else "",
    )


def _group(command: type, field: str) -> str:
    """The heading of the class that has a field first."""
    owners = (each for each in command.__mro__ if field in vars(each).get("__annotations__", {}))
    return vars(next(owners)).get("HEADING", "Options")


def _parser(command: type) -> Any:
    """The parser of a command's options, in the form of argparse."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return tyro.extras.get_parser(command, config=_CONFIG)


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
