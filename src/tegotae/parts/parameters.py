"""Parts as frozen dataclasses: fields that may be traced arrays, and parts within parts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, cast

from tegotae._support.transforms import register_pytree
from tegotae.parts._shapes import Number

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

STATIC = {"static": True}
"""Metadata of a dataclass's field that gives arrays their shape: another value of it is another
program."""


def traceable(cls: type[T]) -> type[T]:
    """Make a frozen dataclass a JAX pytree whose fields are leaves, but for `STATIC` ones.

    The constructor (and so its validation) runs for a user's values, never for traced ones: a
    changed mass or stiffness does not compile a new program.
    """
    fields = dataclasses.fields(cast("type[DataclassInstance]", cls))
    static = [field.name for field in fields if dict(field.metadata) == STATIC]
    names = [field.name for field in fields if field.name not in static]

    def flatten(value: T) -> tuple[tuple[object, ...], tuple[object, ...]]:
        leaves = tuple(getattr(value, name) for name in names)
        return leaves, tuple(getattr(value, name) for name in static)

    def unflatten(fixed: tuple[object, ...], leaves: tuple[object, ...]) -> T:
        value = object.__new__(cls)
        for name, leaf in zip((*names, *static), (*leaves, *fixed), strict=True):
            object.__setattr__(value, name, leaf)
        return value

    register_pytree(cls, flatten, unflatten)
    return cls


def changed(value: T, name: str, change: Callable[[Number], Number]) -> T:
    """The same with one field changed, for values inside a compiled program: nothing is validated.

    Args:
        value: a `traceable` dataclass.
        name: of the field; "terrain.rise_m" is the field `rise_m` of the field `terrain`.
        change: from what the field is to what it becomes.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> changed(Hopper(), "mass_kg", lambda usual: 2 * usual).mass_kg
        0.2
    """
    outer, _, inner = name.partition(".")
    old = getattr(value, outer)
    new = changed(old, inner, change) if inner else change(old)
    copy = object.__new__(type(value))
    for field in dataclasses.fields(cast("DataclassInstance", value)):
        object.__setattr__(copy, field.name, getattr(value, field.name))
    object.__setattr__(copy, outer, new)
    return copy


def within(field: str) -> Any:
    """An attribute of a wrapper that is the same attribute of the part within.

    Args:
        field: the field that holds the part within.

    Example:
        >>> from tegotae.parts.oscillators import Clamped, VanDerPol
        >>> Clamped(VanDerPol()).STATE
        ('radius',)
    """
    return _Within(field)


class _Within:
    """As the part within."""

    def __init__(self, field: str) -> None:
        self.field = field

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, wrapper: object, owner: type | None = None) -> Any:
        return self if wrapper is None else getattr(getattr(wrapper, self.field), self.name)
