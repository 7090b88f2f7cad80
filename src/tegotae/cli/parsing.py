"""Words of the command line to an object of options, by tyro; what it refuses, in one line."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import io
import os
import re
from collections.abc import Iterator, Sequence
from typing import Any, get_type_hints

import tyro

from tegotae._support.errors import TegotaeError
from tegotae.cli.help_texts import WIDTH, examples_text
from tegotae.questions.options import about as about_field

_CONFIG = (
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
    tyro.conf.OmitArgPrefixes,
    tyro.conf.PositionalMetavarFromFieldName,
)


def parse(
    kind: type, words: Sequence[str], prog: str, about: str = "", examples: Sequence[str] = ()
) -> Any:
    """Words as an object of a class.

    Args:
        kind: a dataclass of options.
        words: the options.
        prog: the words before.
        about: what the help says before the options; the docstring of the class by default.
        examples: what it says after them.

    Raises:
        TegotaeError: for words that make none.
        SystemExit: of status 0 after `--help`.
    """
    text = about or inspect.getdoc(kind) or ""
    helps = bool({"-h", "--help"} & {*words})
    try:
        return _cli(kind, ["--help"] if helps else words, prog, helps=helps, description=text)
    except SystemExit:
        print(examples_text(examples))
        raise


def parse_known(kind: type, words: Sequence[str], prog: str) -> tuple[Any, list[str]]:
    """An object of a class of the words that it has a meaning for, and the other words.

    Args:
        kind: a dataclass of options.
        words: the options.
        prog: the words before.

    Raises:
        TegotaeError: for a value that cannot be.
    """
    if not dataclasses.fields(kind):  # type: ignore[arg-type]
        return kind(), [*words]
    helps = [word for word in words if word in ("-h", "--help")]
    words = [word for word in words if word not in helps]
    made, rest = _cli(kind, words, prog, return_unknown_args=True)
    return made, [*rest, *helps]


def _cli(kind: type, words: Sequence[str], prog: str, *, helps: bool = False, **more: Any) -> Any:
    """What tyro makes of words; its refusal is one line."""
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box), _width(helps):
            return tyro.cli(kind, prog=prog, args=list(words), config=_CONFIG, **more)
    except SystemExit:
        if helps:
            raise
        raise TegotaeError(f"{_said(box.getvalue(), prog)}; see {prog} --help") from None


def flags_of(kind: Any) -> Iterator[tuple[str, str, object]]:
    """The options of a class: their flags, or names in capitals; what they are; and defaults.

    Example:
        >>> from tegotae.cli.completion import Completion
        >>> [flag for flag, *_ in flags_of(Completion)]
        ['SHELL']
    """
    hints = get_type_hints(kind, include_extras=True)
    for field in dataclasses.fields(kind):
        hint = hints[field.name]
        if dataclasses.is_dataclass(hint):
            yield from flags_of(hint)
            continue
        positional = tyro.conf.Positional in getattr(hint, "__metadata__", ())
        flag = field.name.upper() if positional else f"--{field.name.replace('_', '-')}"
        yield flag, about_field(kind, field.name), field.default


@contextlib.contextmanager
def _width(helps: bool) -> Iterator[None]:
    """A terminal as wide as help is, or else so wide that no line of an error is broken."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(WIDTH if helps else 100_000)
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
    if re.match(r"Unrecognized options: [^-]", first):
        return f"{first}; names come before options"
    if wrong := re.match(r"Error parsing (\S+): (.*)", first):
        given = " ".join(re.findall(r"'([^']*)'", wrong[2]))
        return f"{wrong[1]} is {given!r}; write {named[0]}"
    return f"{first}; perhaps you meant {', '.join(named)}" if named else first
