"""Commands that are dataclasses of their options with a method `run`."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Sequence
from typing import Any, get_type_hints

from tegotae._support.errors import TegotaeError
from tegotae.api.parameters import Option, field_text, kind_of
from tegotae.cli.kept_texts import HELP
from tegotae.cli.words import help_text, split, values_of

POSITIONAL = "positional"
"""Mark of a field that is given before the options, `Annotated[Path, POSITIONAL]`."""
SEVERAL = "several"
"""Mark of a field whose option may be given several times, each time with one word or more."""


def parse(kind: type, words: Sequence[str], prog: str, examples: Sequence[str] = ()) -> Any:
    """Return words as an object of a class, or its help.

    Args:
        kind: a dataclass of options.
        words: the words after the command.
        prog: the words before.
        examples: lines that a user can type, for help.

    Raises:
        TegotaeError: for words that make none.
    """
    names, pairs = split(words)
    first, options = positional_of(kind), options_of_class(kind)
    if not HELP.isdisjoint(flag for flag, _ in pairs):
        usage = " ".join(filter(None, [prog, first and first.name.upper(), "[OPTIONS]"]))
        text = inspect.getdoc(kind) or ""
        if first is not None:
            text += f"\n\n{first.name.upper()}: {first.description}"
        return help_text(usage, text, {"Options": options}, examples)
    values = values_of(pairs, options, prog, several=_several(kind))
    if first is not None and names:
        values |= values_of([(f"--{first.name}", [*names])], [first], prog)
    elif names:
        raise TegotaeError(f"unexpected argument {names[0]!r}; {prog} takes no name")
    missing = [
        field.name
        for field in dataclasses.fields(kind)
        if field.default is field.default_factory is dataclasses.MISSING
        and field.name not in values
    ]
    if missing:
        flags = [x.upper() if first and x == first.name else f"--{x}" for x in missing]
        raise TegotaeError(f"{prog} needs {', '.join(flags)}; see {prog} --help")
    return kind(**values)


def options_of_class(kind: type) -> list[Option]:
    """Return the options of a class of them."""
    first = positional_of(kind)
    return [x for x in _fields(kind) if first is None or x.name != first.name]


def positional_of(kind: type) -> Option | None:
    """Return the field that is given before the options, if there is one."""
    marked = _marked(kind, POSITIONAL)
    return next((x for x in _fields(kind) if x.name in marked), None)


def flags_of(kind: type) -> list[tuple[str, Option]]:
    """Return the options of a class with their spelling: flags, or a name in capitals.

    Example:
        >>> from tegotae.cli.completion import Completion
        >>> [flag for flag, _ in flags_of(Completion)]
        ['SHELL']
    """
    first = positional_of(kind)
    return [
        (x.name.upper() if x == first else f"--{x.name.replace('_', '-')}", x)
        for x in _fields(kind)
    ]


def _fields(kind: type) -> list[Option]:
    hints, several = get_type_hints(kind), _several(kind)
    options = []
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        value = None if field.default is dataclasses.MISSING else field.default
        hint = tuple[str, ...] if field.name in several else hints[field.name]
        text = field_text(kind, field.name)
        options.append(Option(field.name, kind_of(hint, value), value, text))
    return options


def _several(kind: type) -> list[str]:
    return _marked(kind, SEVERAL)


def _marked(kind: type, mark: str) -> list[str]:
    """Return the names of the fields with a mark."""
    hints = get_type_hints(kind, include_extras=True)
    return [name for name, hint in hints.items() if mark in getattr(hint, "__metadata__", ())]
