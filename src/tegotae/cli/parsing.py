"""Words of the command line to commands and options."""

from __future__ import annotations

import contextlib
import io
import os
import re
import warnings
from collections.abc import Iterator, Sequence
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


def parse_as(kind: type, words: Sequence[str], prog: str, about: str) -> Any:
    """Words as an object of a class.

    Args:
        kind: a dataclass of options.
        words: the options.
        prog: the words before.
        about: what the help says before the options.

    Raises:
        TegotaeError: for words that make none, in one line.
        SystemExit: of status 0 after `--help`.
    """
    if {"-h", "--help"} & {*words}:
        return tyro.cli(kind, prog=prog, description=about, args=["--help"], config=_TASKS)
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box), _wide():
            return tyro.cli(kind, prog=prog, args=list(words), config=_TASKS, registry=_NUMBERS)
    except SystemExit:
        raise TegotaeError(f"{_said(box.getvalue(), prog)}; see {prog} --help") from None


_TASKS = (*_CONFIG, tyro.conf.OmitArgPrefixes)


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
