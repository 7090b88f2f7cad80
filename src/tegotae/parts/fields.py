"""A body's numbers by name: the one place where a name such as "mass_kg" becomes a field.

A field of the body within a wrapper is called "body.mass_kg", one of a terrain "terrain.rise_m": a
*path*. A path's first part may be left to look up: of wrappers and the body within, the outermost
that has a field of this name is meant.
"""

from __future__ import annotations

import dataclasses
import reprlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeVar, cast

from tegotae._support.documents import earlier_names
from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.bodies import Body, BodyWrapper

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

B = TypeVar("B", bound=Body)
T = TypeVar("T")

FieldNumber = float | tuple[float, ...]
"""A number of a body, or one a limb."""
INNER = "body"
"""The field by which a wrapper holds the body within."""


def unwrapped(body: Body) -> Body:
    """The body within all wrappers; a body without wrappers is itself.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> type(unwrapped(Sensors(body=Bar(), delay_s=0.01))).__name__
        'Bar'
    """
    while isinstance(body, BodyWrapper):
        body = body.body
    return body


def paths_of(body: Body) -> dict[str, str]:
    """The path of every field of a body and of the bodies within it, by the field's name.

    Of fields of one name the outermost is meant.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> found = paths_of(Sensors(body=Bar()))
        >>> found["delay_s"], found["inertia_ratio"]
        ('delay_s', 'body.inertia_ratio')
    """
    paths = {name: name for name in _names(body)}
    if not isinstance(body, BodyWrapper):
        return paths
    del paths[INNER]
    within = {name: f"{INNER}.{path}" for name, path in paths_of(body.body).items()}
    return {**within, **paths}


def path_of(body: Body, name: str) -> str:
    """The path of a field, named by its path or by its name alone.

    Args:
        body: a body, with wrappers or without.
        name: "mass_kg", "terrain.rise_m" or "body.mass_kg".

    Raises:
        TegotaeError: for a name that neither the body nor a wrapper has.

    Example:
        >>> from tegotae.parts.bodies import Hopper, Sensors
        >>> path_of(Sensors(body=Hopper()), "mass_kg")
        'body.mass_kg'
    """
    first, dot, tail = name.partition(".")
    if first == INNER and isinstance(body, BodyWrapper):
        return f"{INNER}.{path_of(body.body, tail)}"
    paths = paths_of(body)
    first = _earlier_names_of(body).get(first, first)
    if first not in paths:
        raise unknown(f"field of a {type(unwrapped(body)).__name__}", first, paths)
    path = paths[first] + dot + tail
    _ = _value_at(body, path)
    return path


def _earlier_names_of(body: Body) -> dict[str, str]:
    """The present names of renamed fields of a body and of those within, by earlier names."""
    within = _earlier_names_of(body.body) if isinstance(body, BodyWrapper) else {}
    return within | earlier_names(body)


def value_of(body: Body, name: str) -> object:
    """A field of a body, by name or path.

    Args:
        body: the body, perhaps a wrapper around another one.
        name: such as "mass_kg", or a path such as "body.mass_kg".

    Raises:
        TegotaeError: for a name that neither the body nor a wrapper has.

    Example:
        >>> from tegotae.parts.bodies import Hopper, Sensors
        >>> value_of(Sensors(body=Hopper()), "mass_kg")
        0.1
    """
    return _value_at(body, path_of(body, name))


def number_of(body: Body, name: str) -> FieldNumber:
    """A number of a body, by name or path; a tuple where each limb has one.

    Args:
        body: the body, perhaps a wrapper around another one.
        name: such as "mass_kg", or a path such as "body.mass_kg".

    Raises:
        TegotaeError: for an unknown name, or a field that is no number.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> number_of(Bar(), "hips_m")
        (-0.5, 0.5)
    """
    value = value_of(body, name)
    if not isinstance(value, (int, float, tuple)):
        raise TegotaeError(
            f"{name} of this {type(body).__name__} is {reprlib.repr(value)}, which no change can "
            "make a number; give the body one to begin with"
        )
    return cast(FieldNumber, value)


def numbers_of(body: Body) -> dict[str, FieldNumber]:
    """All numbers of a body and of the bodies within it, by name; tuples are a number a limb.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> numbers_of(Bar())["inertia_ratio"]
        1.0
    """
    values = {name: _value_at(body, path) for name, path in paths_of(body).items()}
    return {name: cast(FieldNumber, x) for name, x in values.items() if _is_number(x)}


def with_fields(body: B, fields: Mapping[str, object]) -> B:
    """A body with other fields, each named by its path or by its name alone, validated.

    A number for a field of the limbs holds for each of them.

    Args:
        body: the body, perhaps a wrapper around another one.
        fields: values by name or path.

    Raises:
        TegotaeError: for an unknown name, or a value that the body refuses.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> with_fields(Sensors(body=Bar()), {"inertia_ratio": 0.5}).body.inertia_ratio
        0.5
    """
    return with_paths(body, {path_of(body, name): value for name, value in fields.items()})


def with_paths(value: T, fields: Mapping[str, object]) -> T:
    """A dataclass with the fields of these paths replaced, as `with_fields` does.

    Args:
        value: the dataclass.
        fields: values by path.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> with_paths(Sensors(body=Bar()), {"body.hips_m": (-1.0, 1.0)}).body.hips_m
        (-1.0, 1.0)
    """
    plain = {path: x for path, x in fields.items() if "." not in path}
    nested: dict[str, dict[str, object]] = {}
    for path, x in fields.items():
        head, dot, tail = path.partition(".")
        if dot:
            nested.setdefault(head, {})[tail] = x
    plain |= {head: with_paths(getattr(value, head), tail) for head, tail in nested.items()}
    for name, x in plain.items():
        current = getattr(value, name)
        if isinstance(current, tuple) and not isinstance(x, tuple):
            plain[name] = (x,) * (len(cast(tuple[object, ...], current)) or 1)
    return cast(T, dataclasses.replace(cast("DataclassInstance", value), **plain))


def _value_at(value: object, path: str) -> object:
    """The value at a path of a dataclass."""
    for part in path.split("."):
        names = _names(value)
        if part not in names:
            raise unknown(f"field of a {type(value).__name__}", part, names)
        value = getattr(value, part)
    return value


def _names(value: object) -> list[str]:
    fields = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    return [field.name for field in fields]


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        inside = cast(tuple[object, ...], value)
        return bool(inside) and all(map(_is_number, inside))
    return isinstance(value, (int, float)) and not isinstance(value, bool)
