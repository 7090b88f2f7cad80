"""Words of the shell as values of options, and the help about them."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, get_args, get_origin

from tegotae._support.errors import TegotaeError, require_known
from tegotae.api.parameters import POSITIONAL, SEVERAL, Option
from tegotae.cli.program import WIDTH, examples_text

_WIDE = 26
"""Width of the column of options in help."""


def split(words: Sequence[str]) -> tuple[tuple[str, ...], list[tuple[str, list[str]]]]:
    """Return the words before the first option, and each option with the words after it.

    Args:
        words: of the shell.

    Example:
        >>> split(["paper", "--drop-m", "-0.1", "--work=net"])
        (('paper',), [('--drop-m', ['-0.1']), ('--work', ['net'])])
    """
    names: list[str] = []
    options: list[tuple[str, list[str]]] = []
    for word in words:
        if word.startswith("--") or word == "-h":
            flag, equals, value = word.partition("=")
            options.append((flag, [value] if equals else []))
        elif options:
            options[-1][1].append(word)
        else:
            names.append(word)
    return tuple(names), options


def flag_of(option: Option) -> str:
    """Return the spelling of an option in the shell; one that is true by default is turned off."""
    if option.mark == POSITIONAL:
        return option.name.upper()
    return f"--{'no-' if option.value is True else ''}{option.name.replace('_', '-')}"


def values_of(
    options: Sequence[tuple[str, list[str]]],
    candidates: Iterable[Option],
    subject: str,
) -> dict[str, Any]:
    """Return the values of the options by path.

    Args:
        options: each with the words after it.
        candidates: options that there are.
        subject: name of their subject, for errors.

    Raises:
        TegotaeError: for an unknown option, with the nearest one, or a value that cannot be.
    """
    flags = {flag_of(option): option for option in candidates}
    values: dict[str, Any] = {}
    for flag, words in options:
        require_known(f"option of {subject}", flag, flags)
        option = flags[flag]
        value = _value(flag, option.kind, words)
        value = option.value is not True if option.kind is bool else value
        if option.mark == SEVERAL:
            value = (*values.get(option.path, ()), value)
        values[option.path] = value
    return values


def known_options(
    options: Sequence[tuple[str, list[str]]], candidates: Iterable[Option], subject: str
) -> dict[str, Any]:
    """Return the values of the options that are known already, and pass over the others."""
    candidates = [*candidates]
    flags = {*map(flag_of, candidates)}
    return values_of([(flag, x) for flag, x in options if flag in flags], candidates, subject)


def metavar(kind: Any) -> str:
    """Return the placeholder after an option, such as FLOAT.

    Example:
        >>> metavar(tuple[float, float]), metavar(tuple[str, ...]), metavar(Literal["a", "b"])
        ('FLOAT FLOAT', 'STR ...', '{a,b}')
    """
    if get_origin(kind) is Literal:
        return f"{{{','.join(map(str, get_args(kind)))}}}"
    if get_origin(kind) is tuple:
        first, *further = get_args(kind)
        if further == [Ellipsis]:
            return f"{metavar(first)} ..."
        return " ".join(map(metavar, (first, *further)))
    return "" if kind is bool else kind.__name__.upper().replace("POSIXPATH", "PATH")


def _value(flag: str, kind: Any, words: Sequence[str]) -> Any:
    """Return the words after an option as a value."""
    syntax = f"write {flag} {metavar(kind)}"
    kinds = get_args(kind) if get_origin(kind) is tuple else () if kind is bool else (kind,)
    if kinds[-1:] == (Ellipsis,):
        kinds = kinds[:1] * len(words)
    elif get_origin(kind) is tuple and len(words) != len(kinds):
        raise TegotaeError(f"{flag} has {len(words)} values of {len(kinds)}; {syntax}")
    if len(words) < len(kinds):
        raise TegotaeError(f"{flag} has no value; {syntax}")
    if len(words) > len(kinds):
        unexpected = words[len(kinds)]
        raise TegotaeError(
            f"{unexpected!r} after {flag} is unexpected; names come before the options"
        )
    try:
        values = tuple(_converted(x, word) for x, word in zip(kinds, words, strict=True))
    except (KeyError, ValueError):
        raise TegotaeError(f"{flag} is {' '.join(words)!r}; {syntax}") from None
    return values if get_origin(kind) is tuple else values[0] if values else True


def _converted(kind: Any, word: str) -> Any:
    """Return a word as a value; raise `KeyError` or `ValueError` for one that is none."""
    if get_origin(kind) is Literal:
        return {str(choice): choice for choice in get_args(kind)}[word]
    return int(word, 10) if kind is int else kind(word)


def help_text(
    usage: str, docstring: str, groups: Mapping[str, Iterable[Option]], examples: Sequence[str]
) -> str:
    """Return the help of a command.

    Args:
        usage: how it is called.
        docstring: its docstring.
        groups: options by heading.
        examples: lines that a user can type.
    """
    paragraphs = inspect.cleandoc(docstring).split("\n\n")
    parts = [f"usage: {usage}", *(textwrap.fill(" ".join(x.split()), WIDTH) for x in paragraphs)]
    for heading, options in groups.items():
        lines = [line for option in options for line in _lines(option)]
        if lines:
            parts.append("\n".join([f"{heading}:", *lines]))
    if examples:
        parts.append(examples_text(examples))
    return "\n\n".join(parts)


def _lines(option: Option) -> list[str]:
    """Return the lines of help about an option."""
    first = f"  {flag_of(option)} {metavar(option.kind)}".rstrip()
    turned_off = "Turn this off: " if option.value is True else ""
    text = turned_off + option.description + _default(option.value)
    indent = " " * _WIDE
    below = textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent) or [""]
    if len(first) <= _WIDE - 2:
        return [first.ljust(_WIDE) + below[0].lstrip(), *below[1:]]
    return [first, *below]


def _default(value: Any) -> str:
    if value is None or isinstance(value, bool) or value in ((), ""):
        return ""
    return f" (default: {' '.join(map(str, value)) if isinstance(value, tuple) else value})"
