"""Options of a question: the subject's own values, of which some are given otherwise.

An options class nests the dataclasses of the physics (a body, a protocol), whose fields are thereby
options. A name may leave out its unit, as in `drop` for `drop_m`.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import reprlib
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.fields import with_paths

T = TypeVar("T")

_UNIT = re.compile(r"_(rad_per_s|m_per_s2?|ns?_per_m|kg_m2|kg|rad|cycles|m|s|n)$")
_PLAIN = (bool, int, float, str, Path)


@dataclass(frozen=True)
class OptionValue:
    """A value that can be given."""

    path: str
    """Where it is in the options, such as body.mass_kg."""
    kind: Any
    """Its type."""
    value: Any
    """The subject's own."""
    about: str
    """What it is."""
    heading: str
    """What it belongs to; empty for the question's own."""


def options_of(options: Any) -> dict[str, OptionValue]:
    """All that can be given, by name without unit; of two that are called alike the outer one.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> options_of(Hopper())["mass"].value
        0.1
    """
    known: dict[str, OptionValue] = {}
    for option in sorted(_leaves(options), key=lambda option: option.path.count(".")):
        known.setdefault(without_unit(option.path.rpartition(".")[2]), option)
    return known


def without_unit(name: str) -> str:
    """The name of an option.

    Example:
        >>> without_unit("drop_time_s"), without_unit("gravity_m_per_s2")
        ('drop_time', 'gravity')
    """
    return _UNIT.sub("", name)


def changed(options: T, given: Mapping[str, Any], subject: str) -> T:
    """The options with what is given.

    Args:
        options: the subject's own.
        given: values by name, with or without unit.
        subject: its name, for errors.

    Raises:
        TegotaeError: for a name that is no option of the subject, with the nearest ones; or a value
            that the options refuse.
    """
    known = options_of(options)
    for name, value in given.items():
        if without_unit(name) not in known:
            raise unknown(f"option of {subject}", name, known)
        _check_kind(name, known[without_unit(name)].kind, value)
    paths = {known[without_unit(name)].path: value for name, value in given.items()}
    return with_paths(options, paths)


def _check_kind(name: str, kind: Any, value: object) -> None:
    """Raise `TegotaeError` for a text or a truth value where a number is due, and the like."""
    many = get_origin(kind) is tuple
    wrong = {
        float: (bool, str, bytes, list, tuple, dict),
        int: (bool, str, bytes, list, tuple, dict),
        str: (bool, int, float, bytes, list, tuple, dict),
    }
    if many and (isinstance(value, str | bytes) or not isinstance(value, Iterable)):
        right = "a list"
    elif not many and isinstance(value, wrong.get(kind, ())):
        right = "a text" if kind is str else "a number"
    else:
        return
    raise TegotaeError(f"{name} is {reprlib.repr(value)}; it must be {right}")


def picked(options: Any, *names: str) -> dict[str, Any]:
    """Options by name, for a function with arguments that are called alike.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> picked(Hopper(), "mass_kg")
        {'mass_kg': 0.1}
    """
    return {name: getattr(options, name) for name in names}


def changes(options: Any, usual: Any) -> dict[str, Any]:
    """The fields of a dataclass that differ from another's.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> changes(Hopper(mass_kg=0.2), Hopper())
        {'mass_kg': 0.2}
    """
    values = ((f.name, getattr(options, f.name)) for f in dataclasses.fields(options) if f.init)
    return {name: value for name, value in values if value != getattr(usual, name)}


def _leaves(options: Any, path: str = "") -> Iterator[OptionValue]:
    hints = get_type_hints(type(options))
    for field in dataclasses.fields(options):
        value, way = getattr(options, field.name), f"{path}{field.name}"
        if dataclasses.is_dataclass(value):
            yield from _leaves(value, f"{way}.")
        elif field.init and (kind := _kind(hints[field.name], value)) is not None:
            heading = type(options).__name__.removesuffix("Options") if path else ""
            yield OptionValue(way, kind, value, about(type(options), field.name), heading)


def _kind(hint: Any, value: Any) -> Any:
    """The type of an option, None of what words cannot say."""
    if get_origin(hint) is Literal:
        return hint
    if get_origin(hint) is tuple and get_args(hint) and {*get_args(hint)} <= {*_PLAIN}:
        return hint  # of so many entries
    if isinstance(value, tuple):
        inner = {type(entry) for entry in value} or {*get_args(hint)} - {Ellipsis}
        (only, *others) = inner
        return tuple[only, ...] if not others and only in _PLAIN else None
    if value is None:
        kinds = [kind for kind in get_args(hint) if kind in _PLAIN or get_origin(kind) is Literal]
        return kinds[0] if NoneType in get_args(hint) and kinds else None
    return next((kind for kind in _PLAIN if isinstance(value, kind)), None)


@cache
def about(owner: type, name: str) -> str:
    """What is said of a field in its class: below it, or in the list of arguments.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> about(Hopper, "mass_kg")
        'Mass m [kg].'
    """
    for kind in owner.__mro__:
        if name not in vars(kind).get("__annotations__", {}):
            continue
        if text := _texts_below(kind).get(name):
            return text
        if said := re.search(rf"^ +{name}: ((?:.|\n +(?! *\w+:))+)", kind.__doc__ or "", re.M):
            text = " ".join(said[1].split())
            return text[0].upper() + text[1:]
    return ""


@cache
def _texts_below(kind: type) -> dict[str, str]:
    """What is said of fields below them, in the source of their class."""
    (body,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    texts: dict[str, str] = {}
    for field, below in pairwise(body.body):  # type: ignore[attr-defined]
        said = below.value if isinstance(below, ast.Expr) else None
        if isinstance(said, ast.Constant) and isinstance(said.value, str):
            texts[getattr(getattr(field, "target", None), "id", "")] = " ".join(said.value.split())
    return texts
