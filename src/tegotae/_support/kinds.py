"""Check of the type of a value, with an error in words."""

from __future__ import annotations

import dataclasses
import reprlib
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

from tegotae._support.errors import TegotaeError


class _PlainKind(NamedTuple):
    fits: Callable[[Any], bool]
    value: str
    """One value in words."""
    values: str
    """Several values in words."""


def _is_number(value: Any, method: str) -> bool:
    has_one_entry = getattr(value, "ndim", 0) == 0
    return hasattr(value, method) and not isinstance(value, bool) and has_one_entry


_PLAIN_KINDS: Mapping[Any, _PlainKind] = {
    bool: _PlainKind(lambda x: isinstance(x, bool), "True or False", "truth values"),
    int: _PlainKind(lambda x: _is_number(x, "__index__"), "a whole number", "whole numbers"),
    float: _PlainKind(lambda x: _is_number(x, "__float__"), "a number", "numbers"),
    str: _PlainKind(lambda x: isinstance(x, str), "a text", "texts"),
    Path: _PlainKind(lambda x: isinstance(x, str | PathLike), "a path", "paths"),
    NoneType: _PlainKind(lambda x: x is None, "None", "None"),
}


def require_kind_of(name: str, kind: Any, value: object) -> None:
    """Raise `TegotaeError` for a value of another type, such as a text where a number is due.

    Args:
        name: name of the option.
        kind: its type; any value passes for one that is neither plain, a dataclass nor abstract.
        value: the value.

    Example:
        >>> require_kind_of("duration_s", float | None, "4")
        Traceback (most recent call last):
        tegotae.TegotaeError: duration_s is '4'; it must be a number or None
    """
    if not fits(kind, value):
        raise TegotaeError(f"{name} is {reprlib.repr(value)}; it must be {_in_words(kind)}")


def fits(kind: Any, value: Any) -> bool:
    """Return whether a value is of a type.

    Args:
        kind: the type.
        value: the value.

    Example:
        >>> fits(float | None, 4), fits(tuple[float, float], (1, 2, 3))
        (True, False)
    """
    if kind in _PLAIN_KINDS:
        return _PLAIN_KINDS[kind].fits(value)
    origin, entries = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return any(fits(x, value) for x in entries)
    if origin is Literal:
        return isinstance(value, str) and value in entries
    if origin is Mapping:
        return isinstance(value, Mapping)
    if origin in (tuple, list, Sequence):
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
            return False
        if origin is not tuple or Ellipsis in entries:
            return not isinstance(value, Sequence) or all(fits(entries[0], x) for x in value)
        values = [*value]
        return len(values) == len(entries) and all(map(fits, entries, values))
    is_contract = isinstance(kind, ABCMeta) and not getattr(kind, "_is_protocol", False)
    is_checked = is_contract or (isinstance(kind, type) and dataclasses.is_dataclass(kind))
    return not is_checked or isinstance(value, kind)


def _in_words(kind: Any) -> str:
    """Return the description of a type for an error."""
    if kind in _PLAIN_KINDS:
        return _PLAIN_KINDS[kind].value
    origin, entries = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(map(_in_words, entries)))
    if origin is Literal:
        return f"one of {', '.join(map(str, entries))}"
    if origin is Mapping:
        return "a mapping of changes"
    if origin in (tuple, list, Sequence):
        if origin is tuple and Ellipsis not in entries:
            return f"a list of {', '.join(map(_in_words, entries))}"
        plain = _PLAIN_KINDS.get(entries[0])
        return f"a list of {plain.values if plain else 'values'}"
    article = "an" if kind.__name__[0] in "AEIOU" else "a"
    return f"{article} {kind.__name__}"
