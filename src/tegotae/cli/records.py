"""Commands that are dataclasses of their options with a method `run`."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Sequence
from typing import Any, get_type_hints

from tegotae._support.errors import TegotaeError
from tegotae.api.parameters import POSITIONAL, SEVERAL, Option, field_text, kind_of
from tegotae.cli.kept_texts import HELP
from tegotae.cli.words import flag_of, help_text, split, values_of


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
    fields = fields_of(kind)
    first = next((x for x in fields if x.mark == POSITIONAL), None)
    options = [x for x in fields if x is not first]
    if not HELP.isdisjoint(flag for flag, _ in pairs):
        usage = " ".join(filter(None, [prog, first and flag_of(first), "[OPTIONS]"]))
        text = inspect.getdoc(kind) or ""
        if first is not None:
            text += f"\n\n{flag_of(first)}: {first.description}"
        return help_text(usage, text, {"Options": options}, examples)
    values = values_of(pairs, options, prog)
    if first is not None and names:
        values |= values_of([(flag_of(first), [*names])], [first], prog)
    elif names:
        raise TegotaeError(f"unexpected argument {names[0]!r}; {prog} takes no name")
    needed = {
        field.name
        for field in dataclasses.fields(kind)
        if field.default is field.default_factory is dataclasses.MISSING
    }
    if missing := [flag_of(x) for x in fields if x.name in needed - values.keys()]:
        raise TegotaeError(f"{prog} needs {', '.join(missing)}; see {prog} --help")
    return kind(**values)


def fields_of(kind: type) -> list[Option]:
    """Return the options of a class, and the field before them if there is one.

    Example:
        >>> from tegotae.cli.completion import Completion
        >>> [flag_of(field) for field in fields_of(Completion)]
        ['SHELL']
    """
    hints, marked = get_type_hints(kind), get_type_hints(kind, include_extras=True)
    options = []
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        value = None if field.default is dataclasses.MISSING else field.default
        (mark,) = getattr(marked[field.name], "__metadata__", ("",))
        hint = tuple[str, ...] if mark == SEVERAL else hints[field.name]
        text = field_text(kind, field.name)
        options.append(Option(field.name, kind_of(hint, value), value, text, mark=mark))
    return options
