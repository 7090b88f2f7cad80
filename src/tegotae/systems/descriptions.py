"""Descriptions as plain values: frozen dataclasses to plain JSON values, and back.

A part (see `tegotae.systems.registry`) becomes a dictionary of its fields with its `kind`, and a
user's one with the hash of its code; any other dataclass, such as a `Timing`, one of its fields
alone, for its place identifies it.
"""

from __future__ import annotations

import dataclasses
import json
import reprlib
from collections.abc import Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints, overload

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, is_of
from tegotae.systems import registry

T = TypeVar("T")


class UsersPartError(TegotaeError):
    """A document needs a user's part that is not known here, or that has other code now."""


def describe(value: object) -> Any:
    """A description as plain JSON values.

    Raises:
        TegotaeError: for a part that is not registered.

    Example:
        >>> from tegotae.parts.terms import Network
        >>> describe(Network(("phase",), hidden=4))
        {'kind': 'Network', 'inputs': ['phase'], 'hidden': 4}
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind = registry.kind_of(value)
        code = registry.code_noted(type(value))
        named: JsonObject = {} if kind is None else {"kind": kind}
        named |= {} if code is None else {registry.CODE: code}
        return named | {f.name: describe(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        entries = cast(Mapping[object, object], value)
        return {str(name): describe(entry) for name, entry in entries.items()}
    if isinstance(value, (tuple, list)):
        return [describe(entry) for entry in cast(Sequence[object], value)]
    if isinstance(value, (np.generic, np.ndarray)):
        return cast(np.ndarray, value).tolist()
    return value


@overload
def restore(value: object, hint: type[T], name: str) -> T: ...
@overload
def restore(value: object, hint: object, name: str) -> Any: ...


def restore(value: object, hint: Any, name: str) -> Any:
    """What `describe` made these JSON values of.

    Fields that a document lacks have their defaults, so that documents from before a field was
    added stay readable.

    Args:
        value: the document.
        hint: the type, as in an annotation.
        name: what the document is, for errors.

    Raises:
        KeyError: for an entry that is missing.
        TypeError: for one of another type, or a part of another kind.
        UsersPartError: for a part that is not registered, or whose code was edited since.
        TegotaeError: for a value that the part itself refuses.

    Example:
        >>> from tegotae.parts.terms import Term
        >>> restore({"kind": "ConstantGain", "start": 2.0}, Term, "gain")
        ConstantGain(start=2.0)
    """
    if get_origin(hint) in (Union, UnionType):
        return _restore_union(value, get_args(hint), name)
    if isinstance(hint, type) and registry.contract_of(hint) is not None:
        return _restore_part(value, hint, name)
    if isinstance(hint, type) and _is_description(hint):
        values = dict(_entries(value, name))
        if "NAME" in vars(hint):
            values.pop("kind")
        return _restore_fields(values, hint)
    if get_origin(hint) in (tuple, list) and any(map(_is_description, get_args(hint))):
        listed = cast(list[object], _checked(value, list, name))
        return tuple(restore(each, get_args(hint)[0], name) for each in listed)
    value = _checked(value, hint, name)
    return _as_tuple(value) if get_origin(hint) is tuple else value


def check_kept(value: object) -> None:
    """See, before long work starts, that a description can be written to a file and read again.

    Args:
        value: a part, or what is made of parts.

    Raises:
        TegotaeError: for a part that is not registered, or has a field that no file can hold.

    Example:
        >>> from tegotae.parts.terms import Network
        >>> check_kept(Network(("phase",), hidden=4))
    """
    for part in registry.parts_in(value):
        if registry.kind_of(part) is None:
            continue
        try:
            document = json.loads(json.dumps(describe(part)))
            kept = describe(restore(document, type(part), "part"))
            why = "" if json.loads(json.dumps(kept)) == document else "it comes back as another one"
        except TegotaeError:
            raise
        except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
            why = (str(error).splitlines() or [type(error).__name__])[0]
        if why:
            raise TegotaeError(
                f"a {type(part).__name__} cannot be saved and read again: {why}; its fields must "
                "be numbers, texts, parts, or tuples of these, as their annotations say"
            )


@overload
def entry(document: Mapping[str, object], name: str, hint: type[T]) -> T: ...
@overload
def entry(document: Mapping[str, object], name: str, hint: object) -> Any: ...
def entry(document: Mapping[str, object], name: str, hint: object) -> object:
    """The restored entry of a document; `KeyError` if it has none."""
    return restore(document[name], hint, name)


def _restore_union(value: object, hints: tuple[object, ...], name: str) -> object:
    if value is None and NoneType in hints:
        return None
    options = [hint for hint in hints if hint is not NoneType]
    descriptions = [hint for hint in options if _is_description(hint)]
    document = cast(dict[str, object], value) if is_of(value, dict) else None
    if len(descriptions) > 1 and document is not None:
        # A part's contract has many kinds; another description is called by its own name.
        called = [hint for hint in descriptions if vars(hint).get("NAME") == document["kind"]]
        rest = [hint for hint in descriptions if "NAME" not in vars(hint)]
        descriptions = called or rest
    if len(descriptions) == 1 and document is not None:
        return restore(document, descriptions[0], name)
    for hint in options:
        if not _is_description(hint) and _fits(value, hint):
            return restore(value, hint, name)
    raise TypeError(f"its {name} is {reprlib.repr(value)}")


def _restore_part(value: object, contract: type, name: str) -> object:
    values = dict(_entries(value, name))
    called = cast(str, _checked(values.pop("kind"), str, "kind"))
    kind = registry.kinds().get(called)
    if kind is None:
        raise UsersPartError(
            f"needs your part {reprlib.repr(called)[1:-1]} ({name}): add --parts FILE.py, or "
            "register it"
        )
    if not issubclass(kind, contract):
        what = contract.__name__.lower()
        raise TypeError(f"its {name} is a {called!r}, which is no {what} known here")
    noted = values.pop(registry.CODE, None)
    if noted is not None and noted != registry.code_noted(kind):
        raise UsersPartError(
            f"was made with other code of {called} than there is now; put that code back, or make "
            "it anew with this one"
        )
    return _restore_fields(values, kind)


def _restore_fields(values: Mapping[str, object], kind: type) -> object:
    hints = get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}
    for name in values:
        if name not in fields:
            raise TypeError(f"a {registry.name_of(kind)} has no {name!r}")
    for name, field in fields.items():
        lacks_default = field.default is field.default_factory is dataclasses.MISSING
        if name not in values and lacks_default:
            raise KeyError(name)
    return kind(**{name: restore(value, hints[name], name) for name, value in values.items()})


def _is_description(hint: object) -> bool:
    """Whether values of this type are dataclasses."""
    return isinstance(hint, type) and (
        registry.contract_of(hint) is not None or dataclasses.is_dataclass(hint)
    )


def _entries(value: object, name: str) -> dict[str, object]:
    """The entries of an object of JSON."""
    return cast(dict[str, object], _checked(value, dict, name))


def _checked(value: object, hint: object, name: str) -> object:
    """The value, if JSON could have made it from one of type `hint`."""
    if not _fits(value, hint):
        raise TypeError(f"its {name} is {reprlib.repr(value)}")
    return value


def _fits(value: object, hint: Any) -> bool:
    if hint is Any:
        return True
    if get_origin(hint) in (list, tuple):
        inside = get_args(hint)
        if not isinstance(value, list):
            return False
        listed = cast(list[object], value)
        if get_origin(hint) is list or inside[-1] is Ellipsis:
            return all(_fits(each, inside[0]) for each in listed)
        return len(listed) == len(inside) and all(map(_fits, listed, inside))
    if get_origin(hint) in (Union, UnionType):
        return any(_fits(value, each) for each in get_args(hint))
    if get_origin(hint) is dict:
        return isinstance(value, dict)
    if isinstance(value, bool):
        return hint is bool
    return isinstance(value, (int, float) if hint is float else hint)


def _as_tuple(value: object) -> object:
    if not isinstance(value, list):
        return value
    return tuple(map(_as_tuple, cast(list[object], value)))
