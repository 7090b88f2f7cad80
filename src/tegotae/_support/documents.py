"""Documents from disk: read in one way, and held against a schema before they are used."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import reprlib
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

import msgspec
import numpy as np

from tegotae._support.errors import TegotaeError, unknown

T = TypeVar("T")

if TYPE_CHECKING:
    Json: TypeAlias = bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"] | None
else:  # no checker at run time follows what names itself
    Json = Any
"""A value that JSON has."""
JsonObject: TypeAlias = dict[str, Json]
"""A document: its entries by name."""
Document: TypeAlias = dict[str, Any]
"""A document as it was read: `fitted` alone says of which kind its entries are."""

MOST_BYTES = 2**28
"""Size of the largest document [bytes]."""
_DEEPEST = 64
"""Levels of lists and objects in each other that a document may have."""

_WORDS = {"object": "an object", "array": "a list", "null": "null", "bool": "true or false"}
_TYPES = {"str": "a text", "int": "a whole number", "float": "a number", **_WORDS}


class DamagedDocumentError(TegotaeError):
    """The content of a file is not valid; `str` says where and why, without the file."""

    __module__ = "tegotae"


def read(path: Path | Traversable) -> Json:
    """Return the JSON value in a file, which is TOML if its name ends in `.toml`.

    Raises:
        FileNotFoundError: if there is none, which callers know more about.
        DamagedDocumentError: if it is none, or none that is safe (`checked`).
        TegotaeError: if it cannot be read, such as without permission.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    if len(content) > MOST_BYTES:
        raise DamagedDocumentError(f"it is larger than {MOST_BYTES >> 20} MiB")
    return parse_toml(content) if path.name.endswith(".toml") else parse_json(content)


def read_as(path: Path, kind: str, convert: Callable[[Json], T]) -> T:
    """Return what a file describes.

    Args:
        path: the file, JSON or TOML.
        kind: what it is to describe, for errors, such as "body".
        convert: from the file's value to what it describes.

    Raises:
        TegotaeError: if there is no file, or it describes something else.
    """
    try:
        return convert(read(path))
    except FileNotFoundError:
        raise TegotaeError(f"there is no file {path}") from None
    except TegotaeError as error:
        raise TegotaeError(f"{path} is no {kind}: {error}") from None


def parse_json(content: bytes | str) -> Any:
    """Return the JSON value of a text, after the checks of `checked`.

    Raises:
        DamagedDocumentError: if there is none.

    Example:
        >>> parse_json('{"seeds": 3}')
        {'seeds': 3}
        >>> parse_json('{"seeds": ')
        Traceback (most recent call last):
        ...
        tegotae.DamagedDocumentError: it is cut short, or no JSON
    """
    try:
        text = content.decode("utf-8") if isinstance(content, bytes) else content
        value = json.loads(text, object_pairs_hook=_entries)
    except DamagedDocumentError:
        raise
    except RecursionError:
        raise DamagedDocumentError(_TOO_DEEP) from None
    except ValueError:  # that of the encoding, too
        raise DamagedDocumentError("it is cut short, or no JSON") from None
    return checked(value)


def parse_toml(content: bytes | str) -> JsonObject:
    """Return the value of a TOML text, after the checks of `checked`.

    Raises:
        DamagedDocumentError: if there is none.

    Example:
        >>> parse_toml("seeds = 3")
        {'seeds': 3}
    """
    try:
        value = tomllib.loads(content.decode("utf-8") if isinstance(content, bytes) else content)
    except RecursionError:
        raise DamagedDocumentError(_TOO_DEEP) from None
    except ValueError as error:  # that of the encoding, too
        raise DamagedDocumentError(f"it is no TOML: {error}") from None
    return checked(value)


def _entries(pairs: list[tuple[str, Json]]) -> JsonObject:
    """Return the entries of a JSON object; refuse two with one name."""
    entries = dict(pairs)
    if len(entries) < len(pairs):
        (name, times), *_ = Counter(name for name, _ in pairs).most_common(1)
        raise DamagedDocumentError(f"its entry {reprlib.repr(name)} is there {times} times")
    return entries


_TOO_DEEP = f"it is nested deeper than {_DEEPEST} levels"


_HARMS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters, halves of characters, and what turns the direction of writing."""


def checked(value: T, _level: int = 1) -> T:
    """Return a JSON value if nothing in it can harm a reader, a console or a figure.

    Raises:
        DamagedDocumentError: if it is nested too deep, or has a text with control characters (such
            as the commands of a terminal) or halves of characters (lone surrogates).
    """
    if _level > _DEEPEST:
        raise DamagedDocumentError(_TOO_DEEP)
    if isinstance(value, str) and (harm := _HARMS.search(value)):
        raise DamagedDocumentError(
            f"its text {reprlib.repr(value)} has the character {harm[0]!r}, which no text of such "
            "a file has"
        )
    parts = [x for pair in value.items() for x in pair] if isinstance(value, dict) else value
    if isinstance(parts, list):
        for entry in cast(list[object], parts):
            if isinstance(entry, (str, dict, list)):
                checked(entry, _level + 1)
    return value


def texts_in(value: Json) -> Iterator[str]:
    """Yield all texts in a JSON value, but not the names of its entries.

    Example:
        >>> list(texts_in({"env": "Hopper-v5", "settings": [{"ground": "ice"}, 3]}))
        ['Hopper-v5', 'ice']
    """
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        yield from texts_in([*value.values()])
    elif isinstance(value, Sequence):
        for entry in value:
            yield from texts_in(entry)


_LATER = "left out of documents at its default"
_EARLIER_NAME = "earlier name in documents"
_NO_DEFAULT: Any = dataclasses.MISSING
_WRITTEN = "written by its earlier name"


def later(default: T) -> T:
    """Return the default of a field that was added after its dataclass was first used.

    Documents leave the field out where it has its default. So a new field of a body or of a fitness
    gives no record another name, and files from before stay what they are. The default may say what
    the field may be, as `positive(0.1)` does.

    Example:
        >>> @dataclasses.dataclass(frozen=True)
        ... class Spring:
        ...     stiffness: float = 5.0
        ...     hardening: float = later(0.0)
        >>> described_fields(Spring()), described_fields(Spring(hardening=0.1))
        ({'stiffness': 5.0}, {'stiffness': 5.0, 'hardening': 0.1})
    """
    return cast(T, _with_metadata(default, {_LATER: True}))


def kept_as(name: str, default: T = _NO_DEFAULT, *, written: bool = True) -> T:
    """Return the default of a field that documents keep under an earlier name.

    Documents from before a field was renamed stay readable. By default new ones have the earlier
    name, too: no record gets another key, and no kept file is to be made again.

    Args:
        name: the earlier name.
        default: the default of the field, if it has one; it may be that of `positive` or `later`.
        written: False to write documents with the field's present name; both are read.

    Example:
        >>> @dataclasses.dataclass(frozen=True)
        ... class Spring:
        ...     stiffness_n_per_m: float = kept_as("stiffness", 5.0)
        >>> described_fields(Spring())
        {'stiffness': 5.0}
        >>> renamed_entries(Spring, {"stiffness": 3.0})
        {'stiffness_n_per_m': 3.0}
    """
    return cast(T, _with_metadata(default, {_EARLIER_NAME: name, _WRITTEN: written}))


def _with_metadata(default: Any, metadata: Mapping[Any, Any]) -> Any:
    """Return a dataclass field with a default, which may be a field itself."""
    if not isinstance(default, dataclasses.Field):
        return dataclasses.field(default=default, metadata=metadata)
    defaults = {"default": default.default, "default_factory": default.default_factory}
    initial: Any = {k: x for k, x in defaults.items() if x is not dataclasses.MISSING}
    return dataclasses.field(**initial, metadata={**default.metadata, **metadata})


def described_fields(value: Any) -> dict[str, Any]:
    """Return a dataclass's fields by their names in documents, without `later` ones at their
    default.
    """
    fields = {field: getattr(value, field.name) for field in dataclasses.fields(value)}
    return {
        document_name(f): x for f, x in fields.items() if _LATER not in f.metadata or x != f.default
    }


def document_name(field: dataclasses.Field[Any]) -> str:
    """Return the name of a field in documents that are written now."""
    return field.metadata[_EARLIER_NAME] if field.metadata.get(_WRITTEN) else field.name


def earlier_names(kind: Any) -> dict[str, str]:
    """Return the present names of a dataclass's renamed fields (`kept_as`), by their earlier
    names.
    """
    fields = [field for field in dataclasses.fields(kind) if _EARLIER_NAME in field.metadata]
    return {field.metadata[_EARLIER_NAME]: field.name for field in fields}


def renamed_entries(kind: Any, entries: Mapping[str, T]) -> dict[str, T]:
    """Return a document's entries by the present names of the dataclass's fields (`kept_as`).

    Raises:
        DamagedDocumentError: for a field that is there under both names.
    """
    names = earlier_names(kind)
    for earlier, name in names.items():
        if earlier in entries and name in entries:
            raise DamagedDocumentError(f"its entry {name!r} is there as {earlier!r}, too")
    return {names.get(name, name): entry for name, entry in entries.items()}


def as_json(value: object) -> Any:
    """Return a value in the types of JSON: null for an undefined or infinite number.

    Example:
        >>> as_json({"lag": np.array([0.5, np.nan]), 2: (np.int64(1), None)})
        {'lag': [0.5, None], '2': [1, None]}
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: as_json(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): as_json(entry) for key, entry in value.items()}
    if isinstance(value, (tuple, list)):
        return [as_json(entry) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return as_json(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def fitted(value: object, schema: type[T], name: str = "") -> T:
    """Return the value converted to a schema: a `msgspec.Struct`, a dataclass, or any type of
    those.

    Args:
        value: JSON values.
        schema: the type.
        name: what they are, for errors; by default the whole document.

    Raises:
        DamagedDocumentError: if it is not; it says which entry, what is there and what should be.

    Example:
        >>> fitted({"population": 16}, dict[str, int])
        {'population': 16}
        >>> fitted({"population": 16}, dict[str, str])
        Traceback (most recent call last):
        ...
        tegotae.DamagedDocumentError: an entry is a whole number; it must be a text
    """
    try:
        return msgspec.convert(value, schema)
    except msgspec.ValidationError as error:
        raise DamagedDocumentError(_formatted(value, str(error), name, schema)) from None


def _formatted(document: object, error: str, name: str, schema: Any) -> str:
    """Translate the validator's message into ours: `Expected `int`, got `str` - at `$.a.b[0]``."""
    text, _, place = error.partition(" - at `$")
    where = (name + place.rstrip("`")).lstrip(".")
    if missing := re.fullmatch(r"Object missing required field `(.*)`", text):
        return f"it has no entry {'.'.join(filter(None, [where, missing[1]]))!r}"
    if extra := re.fullmatch(r"Object contains unknown field `(.*)`", text):
        entries = _entries_of(msgspec.inspect.type_info(schema), place.rstrip("`"))
        return str(unknown(f"entry of {where}" if where else "entry", extra[1], entries))
    subject = f"its {where}" if where and "..." not in where else "an entry" if where else "it"
    value = None if "..." in where else _value(document, place.rstrip("`"))
    if text == "Number out of range":
        return f"{subject} is {value}, which is too large"
    expected = re.match(r"Expected `(.*?)`(?:, got `(.*)`| (.*))?", text)
    if expected is None:  # a part's own refusal, such as of a negative mass
        return f"{where}: {text}" if where else text
    types = " or ".join(_TYPES.get(kind, kind) for kind in expected[1].split(" | "))
    if value is None or not where:
        value = _TYPES.get(expected[2] or "", expected[2] or "another")
    return f"{subject} is {value}; it must be {types} {expected[3] or ''}".rstrip()


def _entries_of(kind: Any, place: str) -> list[str]:
    """Return the names of the entries that a schema has at a place such as `.a.b[0]`."""
    step = re.match(r"[.\[]([^.\[\]]+|\.\.\.)\]?", place)
    fields = {field.encode_name: field.type for field in getattr(kind, "fields", ())}
    if step is None:
        inner, names = getattr(kind, "types", ()), [*fields]
    else:
        names, place = [], place[step.end() :]
        parts = (getattr(kind, part, None) for part in ("item_type", "value_type"))
        inner = (fields.get(step[1]), *parts, *getattr(kind, "types", ()))
    return names + [name for part in inner if part for name in _entries_of(part, place)]


def _value(document: object, place: str) -> str:
    """Return the entry at a place such as `.a.b[0]`, shortened."""
    for step in re.findall(r"[^.\[\]]+", place):
        entries = cast(dict[str, object], document)
        document = document[int(step)] if isinstance(document, list) else entries[step]
    return reprlib.repr(document)


CODE = "sha256"
"""The entry of a document that has the hash of a user's code."""


def differing(actual: Json, reference: Json) -> list[str]:
    """Return the names of entries that differ between two documents, such as `fitness.work` or
    `code of MyTerm`.

    Args:
        actual: a document, JSON values.
        reference: another one.

    Example:
        >>> differing({"seeds": 1, "body": {"mass_kg": 1}}, {"seeds": 1, "body": {"mass_kg": 2}})
        ['body.mass_kg']
        >>> differing({"kind": "MyTerm", "sha256": "a0"}, {"kind": "MyTerm", "sha256": "b1"})
        ['code of MyTerm']
    """
    names = _differing(_without_code(actual), _without_code(reference))
    theirs, ours = dict(_codes(actual)), dict(_codes(reference))
    edited = [part for part in {**theirs, **ours} if theirs.get(part) != ours.get(part)]
    # The code of a part that one of them lacks is not worth a word beside that.
    return names + [f"code of {x}" for x in edited if not names or (x in theirs and x in ours)]


def _codes(document: Json) -> Iterator[tuple[str, str]]:
    """Yield the code hashes in a document, each with the name of its object."""
    if isinstance(document, Mapping):
        code = document.get(CODE)
        if isinstance(code, Mapping):
            yield from ((str(label), str(digest)) for label, digest in code.items())
        elif code is not None:
            names = (document.get(key) for key in ("kind", "name", "algorithm"))
            yield next((str(name) for name in names if name), "a part"), str(code)
        document = [*document.values()]
    if isinstance(document, list):
        for entry in document:
            yield from _codes(entry)


def _without_code(document: Json) -> Json:
    if isinstance(document, list):
        return [_without_code(entry) for entry in document]
    if not isinstance(document, Mapping):
        return document
    return {name: _without_code(entry) for name, entry in document.items() if name != CODE}


def _differing(actual: Json, reference: Json, name: str = "") -> list[str]:
    if actual == reference:
        return []
    if isinstance(actual, list) and isinstance(reference, list) and len(actual) == len(reference):
        pairs = [(a, b, name) for a, b in zip(actual, reference, strict=True)]
    elif (
        isinstance(actual, Mapping)
        and isinstance(reference, Mapping)
        and not name.endswith("controller")
        and actual.get("kind") == reference.get("kind")
    ):
        keys = {**reference, **actual}
        pairs = [
            (actual.get(key, _NOTHING), reference.get(key, _NOTHING), f"{name}.{key}".lstrip("."))
            for key in keys
        ]
    else:
        return [name.removeprefix("experiment.").removeprefix("system.")]
    return list(dict.fromkeys(difference for pair in pairs for difference in _differing(*pair)))


_NOTHING: Any = object()
"""Placeholder of an entry that a document lacks."""
