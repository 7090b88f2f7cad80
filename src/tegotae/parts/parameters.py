"""Parts as frozen dataclasses: fields that may be traced arrays, and parts within parts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar, cast

from tegotae._support.errors import TegotaeError, require_count, require_finite, require_kind
from tegotae._support.transforms import register_pytree
from tegotae.parts._shapes import Number

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

STATIC = {"static": True}
"""Metadata of a dataclass's field that gives arrays their shape: another value of it is another
program."""


_CHECK = "check"


def finite(
    default: Any = dataclasses.MISSING,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> Any:
    """Define a field that is a finite number within bounds; None is allowed where it is the
    default.

    Args:
        default: of the field; without one it has to be given.
        above: what it must be greater than.
        least: what it must not be less than.
        most: what it must not be greater than.

    Example:
        >>> @dataclasses.dataclass(frozen=True)
        ... class Spring(Part):
        ...     stiffness_n_per_m: float = finite(5.0, above=0.0)
        >>> Spring(-1.0)
        Traceback (most recent call last):
        tegotae.TegotaeError: stiffness_n_per_m is -1; it must be greater than 0
    """
    check = partial(require_finite, above=above, least=least, most=most)
    return dataclasses.field(default=default, metadata={_CHECK: check})


def positive(default: float | None) -> Any:
    """Define a field that is a finite number above zero."""
    return finite(default, above=0.0)


def not_negative(default: float) -> Any:
    """Define a field that is a finite number of at least zero."""
    return finite(default, least=0.0)


def whole(
    default: Any = dataclasses.MISSING,
    *,
    least: int = 1,
    most: int | None = None,
    static: bool = False,
) -> Any:
    """Define a field that is a whole number.

    Args:
        default: of the field; without one it has to be given.
        least: the smallest that it may be.
        most: the largest.
        static: whether it gives arrays their shape (`STATIC`).
    """
    check = {_CHECK: partial(require_count, least=least, most=most)}
    return dataclasses.field(default=default, metadata=check | (STATIC if static else {}))


def a_part(kind: type, right: str, default: Callable[[], object]) -> Any:
    """Define a field that is another part.

    Args:
        kind: what it must be an instance of.
        right: what that is called in errors, such as "an EllipticFoot".
        default: makes the usual one.
    """
    check = partial(require_kind, kind=kind, right=right)
    return dataclasses.field(default_factory=default, metadata={_CHECK: check})


def numbers(default: Any) -> Any:
    """Define a field that is a tuple of finite numbers; a list is converted."""
    return dataclasses.field(default=default, metadata={_CHECK: _require_numbers})


def _require_numbers(name: str, values: object) -> tuple[float, ...]:
    if not isinstance(values, Iterable) or isinstance(values, str):
        raise TegotaeError(f"{name} is {values!r}; it must be numbers, such as (-0.5, 0.5)")
    entries = tuple(cast(Iterable[float], values))
    for entry in entries:
        require_finite(f"an entry of {name}", entry)
    return entries


class Part:
    """A frozen dataclass whose fields are checked where they say what they may be (`finite`)."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(cast("DataclassInstance", self)):
            value = getattr(self, field.name)
            if _CHECK in field.metadata and not (value is None is field.default):
                checked = field.metadata[_CHECK](field.name, value)
                if checked is not None:
                    object.__setattr__(self, field.name, checked)


def traceable(cls: type[T]) -> type[T]:
    """Make a frozen dataclass a JAX pytree whose fields are leaves, but for `STATIC` ones.

    The constructor (and so its validation) runs for a user's values, never for traced ones: a
    changed mass or stiffness does not compile a new program.
    """
    fields = dataclasses.fields(cast("type[DataclassInstance]", cls))
    static = [field.name for field in fields if "static" in field.metadata]
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
    """Return the part with one field changed, for values inside a compiled program: nothing is
    validated.

    Args:
        value: a `traceable` dataclass.
        name: of the field; "terrain.rise_m" is the field `rise_m` of the field `terrain`.
        change: from what the field is to what it becomes.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> changed(Hopper(), "mass_kg", lambda usual: 2 * usual).mass_kg
        0.2
    """
    head, _, tail = name.partition(".")
    old = getattr(value, head)
    new = changed(old, tail, change) if tail else change(old)
    copy = object.__new__(type(value))
    for field in dataclasses.fields(cast("DataclassInstance", value)):
        object.__setattr__(copy, field.name, getattr(value, field.name))
    object.__setattr__(copy, head, new)
    return copy


def within(field: str) -> Any:
    """Forward an attribute of a wrapper to the part within.

    Args:
        field: the field that holds the part within.

    Example:
        >>> from tegotae.parts.oscillators import Clamped, VanDerPol
        >>> Clamped(VanDerPol()).STATE
        ('radius',)
    """
    return _Within(field)


class _Within:
    """A field that delegates to the wrapped part."""

    def __init__(self, field: str) -> None:
        self.field = field

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, wrapper: object, owner: type | None = None) -> Any:
        return self if wrapper is None else getattr(getattr(wrapper, self.field), self.name)
