"""Fields by name: the one place where a name such as "mass_kg" becomes a field of a frozen value.

A field of the body within a wrapper is called "body.mass_kg", one of a terrain "terrain.rise_m": a
*path*. A path's first part may be left to look up in the fields that the class names as `INSIDE`:
of wrappers and the body within, of a system and its release, the outermost that has a field of this
name is meant.
"""

from __future__ import annotations

import dataclasses
import reprlib
from collections.abc import Mapping
from numbers import Real
from operator import attrgetter
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np

from tegotae._support.documents import earlier_names
from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.bodies import Body, BodyWrapper

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

FieldNumber = float | tuple[float, ...]
"""A number of a body, or one a limb."""


def unwrapped(body: Body) -> Body:
    """Return the body inside all wrappers, or a body without wrappers itself.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> type(unwrapped(Sensors(body=Bar(), delay_s=0.01))).__name__
        'Bar'
    """
    while isinstance(body, BodyWrapper):
        body = body.body
    return body


def paths_of(value: object) -> dict[str, str]:
    """Return the path of every field of a value and of nested values, by the field's name.

    Of fields of one name the outermost is meant.

    Args:
        value: a body, or another dataclass.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> found = paths_of(Sensors(body=Bar()))
        >>> found["delay_s"], found["inertia_ratio"]
        ('delay_s', 'body.inertia_ratio')
    """
    inside = _inside(value)
    paths = {name: name for name in _names(value) if name not in inside}
    for holder in inside:
        for name, path in paths_of(getattr(value, holder)).items():
            paths.setdefault(name, f"{holder}.{path}")
    return paths


def path_of(value: object, name: str) -> str:
    """Return the path of a field, named by its path or by its name alone.

    Args:
        value: a body, with wrappers or without, or another dataclass.
        name: "mass_kg", "terrain.rise_m" or "body.mass_kg".

    Raises:
        TegotaeError: for a name that there is not.

    Example:
        >>> from tegotae.parts.bodies import Hopper, Sensors
        >>> path_of(Sensors(body=Hopper()), "mass_kg")
        'body.mass_kg'
    """
    first, dot, tail = name.partition(".")
    first = _earlier_names_of(value).get(first, first)
    if first in _names(value):
        return first + dot + (path_of(getattr(value, first), tail) if dot else "")
    for holder in _inside(value):
        inner = getattr(value, holder)
        if first in paths_of(inner) or first in _inside(inner):
            return f"{holder}.{path_of(inner, first + dot + tail)}"
    whole = unwrapped(value) if isinstance(value, Body) else value
    raise unknown(f"field of a {type(whole).__name__}", first, paths_of(value))


def _earlier_names_of(value: object) -> dict[str, str]:
    """Return the present names of renamed fields of a value and its nested values, by earlier
    names.
    """
    names: dict[str, str] = {}
    for holder in _inside(value):
        names |= _earlier_names_of(getattr(value, holder))
    return names | (earlier_names(value) if dataclasses.is_dataclass(value) else {})


def value_of(value: object, name: str) -> object:
    """Return a field of a value, by name or path.

    Args:
        value: a body, perhaps a wrapper around another one, or another dataclass.
        name: such as "mass_kg", or a path such as "body.mass_kg".

    Raises:
        TegotaeError: for a name that there is not.

    Example:
        >>> from tegotae.parts.bodies import Hopper, Sensors
        >>> value_of(Sensors(body=Hopper()), "mass_kg")
        0.1
    """
    return attrgetter(path_of(value, name))(value)


def number_of(body: Body, name: str) -> FieldNumber:
    """Return a number of a body by name or path, or a tuple if every limb has its own.

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
    """Return all numbers of a body and of nested bodies by name; tuples hold one number per limb.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> numbers_of(Bar())["inertia_ratio"]
        1.0
    """
    values = {name: attrgetter(path)(body) for name, path in paths_of(body).items()}
    return {name: cast(FieldNumber, x) for name, x in values.items() if _is_number(x)}


def replace(value: T, changes: Mapping[str, object]) -> T:
    """Return a frozen value with other fields, each named by its path or by its name, validated.

    A number for a field of the limbs holds for each of them.

    Args:
        value: a body, a system, an experiment or another dataclass.
        changes: values by name or path.

    Raises:
        TegotaeError: for an unknown name, or a value that is refused.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> replace(Sensors(body=Bar()), {"inertia_ratio": 0.5}).body.inertia_ratio
        0.5
        >>> replace(Sensors(body=Bar()), {"body.hips_m": (-1.0, 1.0)}).body.hips_m
        (-1.0, 1.0)
    """
    fields: dict[str, object] = {}
    nested: dict[str, dict[str, object]] = {}
    for name, x in changes.items():
        head, dot, tail = path_of(value, name).partition(".")
        if dot:
            nested.setdefault(head, {})[tail] = x
        else:
            fields[head] = x
    fields |= {
        head: replace(fields.get(head, getattr(value, head)), tails)
        for head, tails in nested.items()
    }
    for name, x in fields.items():
        current = getattr(value, name)
        if isinstance(current, tuple) and (
            isinstance(x, Real) or (isinstance(x, np.ndarray) and x.ndim == 0)
        ):
            fields[name] = (x,) * (len(cast(tuple[object, ...], current)) or 1)
    return cast(T, dataclasses.replace(cast("DataclassInstance", value), **fields))


def _inside(value: object) -> tuple[str, ...]:
    return getattr(type(value), "INSIDE", ())


def _names(value: object) -> list[str]:
    fields = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    return [field.name for field in fields]


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        inside = cast(tuple[object, ...], value)
        return bool(inside) and all(map(_is_number, inside))
    return isinstance(value, (int, float)) and not isinstance(value, bool)
