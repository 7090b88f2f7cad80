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

from tegotae._support.documents import (
    DamagedDocumentError,
    JsonObject,
    described_fields,
    document_name,
    fitted,
    renamed_entries,
)
from tegotae._support.errors import TegotaeError, is_of, require_known
from tegotae.systems import registry

T = TypeVar("T")


class UsersPartError(TegotaeError):
    """A document needs a user's part that is not known here, or that has other code now."""


def describe(value: object) -> Any:
    """Return a description as plain JSON values.

    Raises:
        TegotaeError: for a part that is not registered.

    Example:
        >>> from tegotae.parts.terms import Network
        >>> describe(Network(("phase",), hidden=4))
        {'kind': 'Network', 'inputs': ['phase'], 'hidden': 4}
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind, code = registry.kind_of(value), registry.code_noted(type(value))
        header: JsonObject = {} if kind is None else {"kind": kind}
        header |= {} if code is None else {registry.CODE: code}
        return header | {name: describe(x) for name, x in described_fields(value).items()}
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
    """Rebuild a value from its JSON description (`describe`).

    Fields that a document lacks have their defaults, so that documents from before a field was
    added stay readable.

    Args:
        value: the document.
        hint: the type, as in an annotation.
        name: what the document is, for errors.

    Raises:
        UsersPartError: for a part that is not registered, or whose code was edited since.
        DamagedDocumentError: for an entry that is missing, of another type or of another kind.
        TegotaeError: for a value that the part itself refuses.

    Example:
        >>> from tegotae.parts.terms import Term
        >>> restore({"kind": "ConstantGain", "start": 2.0}, Term, "gain")
        ConstantGain(start=2.0)
    """
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    inside = [get_args(option)[0] for option in options if get_origin(option) in (tuple, list)]
    if is_of(value, list) and any(map(_is_description, inside)):
        return tuple(restore(entry, inside[0], name) for entry in cast(list[object], value))
    described = [option for option in options if _is_description(option)]
    if described and is_of(value, dict):
        return _restored(cast(dict[str, Any], value), described, name)
    if described and not (value is None and NoneType in options):
        raise DamagedDocumentError(f"its {name} is {reprlib.repr(value)}")
    if not described:
        fitted(value, hint, name)
    return _as_tuple(value)


def document_path(kind: type, path: str) -> str:
    """Return the path of a field in documents of a dataclass, by the names of its fields.

    The names differ where a field was renamed (`tegotae._support.documents.kept_as`).

    Args:
        kind: the dataclass.
        path: the names of the fields, such as `system.release.height_m`.

    Raises:
        TegotaeError: for a field that the dataclass, or no part that may be in it, has.

    Example:
        >>> from tegotae.systems.experiment import Experiment
        >>> document_path(Experiment, "system.body.mass_kg")
        'system.body.mass_kg'
        >>> document_path(Experiment, "system.body.mass")
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: no field of a Body is called 'mass'; did you mean mass_kg, ...?
    """
    return ".".join(_document_names([kind], path))


def _document_names(kinds: Sequence[type], path: str) -> list[str]:
    """Return the names in documents along a path of fields of dataclasses or contracts."""
    first, _, tail = path.partition(".")
    parts: list[Any] = [
        part for kind in kinds for part in registry.kinds().values() if issubclass(part, kind)
    ]
    fields = {f.name: (f, part) for part in parts or kinds for f in dataclasses.fields(part)}
    require_known(f"field of a {kinds[0].__name__}", first, fields)
    field, owner = fields[first]
    if not tail:
        return [document_name(field)]
    hint = get_type_hints(owner)[first]
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return [document_name(field), *_document_names([*filter(_is_description, options)], tail)]


def check_kept(value: object) -> None:
    """Check, before long work starts, that a description can be written to a file and read again.

    Args:
        value: a part, or what is made of parts.

    Raises:
        TegotaeError: for a part that is not registered, or has a field that no file can hold.

    Example:
        >>> from tegotae.parts.terms import Network
        >>> check_kept(Network(("phase",), hidden=4))
    """
    for part in registry.parts_in(value):
        description = describe(part)
        try:
            document = json.loads(json.dumps(description))
            restored_document = describe(restore(document, type(part), "part"))
            complaint = (
                ""
                if json.loads(json.dumps(restored_document)) == document
                else "it comes back as another one"
            )
        except (DamagedDocumentError, TypeError, RecursionError) as error:
            complaint = (str(error).splitlines() or [type(error).__name__])[0]
        if complaint:
            raise TegotaeError(
                f"a {type(part).__name__} cannot be saved and read again: {complaint}; its fields "
                "must be numbers, texts, parts, or tuples of these, as their annotations say"
            )


def _restored(document: dict[str, Any], options: Sequence[type], name: str) -> object:
    """Restore the dataclass of a document, one of some classes or contracts."""
    kind = _kind(document, options, name)
    reserved = ("kind", registry.CODE)
    entries = renamed_entries(kind, {k: x for k, x in document.items() if k not in reserved})
    if registry.CODE in document and document[registry.CODE] != registry.code_noted(kind):
        raise UsersPartError(
            f"was made with other code of {registry.name_of(kind)} than there is now; put that "
            "code back, or make it anew with this one"
        )
    hints = get_type_hints(kind)
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        lacks_default = field.default is field.default_factory is dataclasses.MISSING
        if field.name not in entries and lacks_default:
            raise DamagedDocumentError(f"it has no entry {field.name!r}")
    if unknown := [name for name in entries if name not in hints]:
        raise DamagedDocumentError(f"a {registry.name_of(kind)} has no {unknown[0]!r}")
    try:
        return kind(**{name: restore(value, hints[name], name) for name, value in entries.items()})
    except TegotaeError:
        raise
    except (TypeError, ValueError, OverflowError) as error:  # of a user's part
        raise DamagedDocumentError(str(error)) from None


def _kind(document: Mapping[str, Any], options: Sequence[type], name: str) -> type:
    """Return the class of a document: a part by its kind, another one by its `NAME`, or its
    place.
    """
    contracts = tuple(kind for kind in options if registry.contract_of(kind) is not None)
    candidates = [kind for kind in options if kind not in contracts]
    kind_name: str | None = fitted(document.get("kind"), cast(Any, str | None), "kind")
    for kind in candidates:
        if vars(kind).get("NAME") == kind_name:
            return kind
    if kind_name is None:
        raise DamagedDocumentError("it has no entry 'kind'")
    kind = registry.kinds().get(kind_name)
    if kind is None:
        raise UsersPartError(
            f"needs your part {reprlib.repr(kind_name)[1:-1]} ({name}): add --parts FILE.py, or "
            "register it"
        )
    if not issubclass(kind, contracts):
        contract_names = " or ".join(contract.__name__.lower() for contract in contracts)
        raise DamagedDocumentError(
            f"its {name} is a {kind_name!r}, which is no {contract_names} known here"
        )
    return kind


def _is_description(hint: object) -> bool:
    """Return whether values of this type are dataclasses."""
    return isinstance(hint, type) and (
        registry.contract_of(hint) is not None or dataclasses.is_dataclass(hint)
    )


def _as_tuple(value: object) -> object:
    if not isinstance(value, list):
        return value
    return tuple(map(_as_tuple, cast(list[object], value)))
