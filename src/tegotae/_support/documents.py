"""Documents from disk: read in one way, and held against a schema before they are used."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import reprlib
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

import msgspec
import numpy as np

from tegotae._support.errors import TegotaeError

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
DEEPEST = 64
"""Levels of lists and objects in each other that a document may have."""

_WORDS = {"object": "an object", "array": "a list", "null": "null", "bool": "true or false"}
_TYPES = {"str": "a text", "int": "a whole number", "float": "a number", **_WORDS}


class DamagedDocumentError(TegotaeError):
    """What a file holds is not what it should be; `str` says where and why, without the file."""

    __module__ = "tegotae"


def read(path: Path | Traversable) -> Json:
    """The JSON value in a file.

    Raises:
        FileNotFoundError: if there is none, which callers know more about.
        DamagedDocumentError: if it is no JSON, or none that is safe (`checked`).
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
    return parse(content)


def parse(content: bytes | str) -> Any:
    """The JSON value of a text, `checked`.

    Raises:
        DamagedDocumentError: if there is none.

    Example:
        >>> parse('{"seeds": 3}')
        {'seeds': 3}
        >>> parse('{"seeds": ')
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


def parse_toml(text: str) -> JsonObject:
    """The value of a TOML text, `checked`.

    Raises:
        DamagedDocumentError: if there is none.

    Example:
        >>> parse_toml("seeds = 3")
        {'seeds': 3}
    """
    try:
        value = tomllib.loads(text)
    except RecursionError:
        raise DamagedDocumentError(_TOO_DEEP) from None
    except tomllib.TOMLDecodeError as error:
        raise DamagedDocumentError(f"it is no TOML: {error}") from None
    return checked(value)


def _entries(pairs: list[tuple[str, Json]]) -> JsonObject:
    """The entries of a JSON object: of two with one name none is preferred."""
    entries = dict(pairs)
    if len(entries) < len(pairs):
        (name, times), *_ = Counter(name for name, _ in pairs).most_common(1)
        raise DamagedDocumentError(f"its entry {reprlib.repr(name)} is there {times} times")
    return entries


_TOO_DEEP = f"it is nested deeper than {DEEPEST} levels"


def checked(value: T) -> T:
    """The JSON value itself, if nothing in it can harm a reader, a console or a figure.

    Raises:
        DamagedDocumentError: if it is nested too deep, or has a text with control characters (such
            as the commands of a terminal) or halves of characters (lone surrogates).
    """
    level: list[object] = [value]
    for _ in range(DEEPEST):
        inner: list[object] = []
        for each in level:
            if isinstance(each, str):
                _require_text(each)
            elif isinstance(each, dict):
                entries = cast(dict[object, object], each)
                inner += [*entries.keys(), *entries.values()]
            elif isinstance(each, list):
                inner += cast(list[object], each)
        if not inner:
            return value
        level = inner
    raise DamagedDocumentError(_TOO_DEEP)


def as_json(value: object) -> Any:
    """A value in the types that JSON has: null for what is undefined or not finite.

    Example:
        >>> as_json({"lag": np.array([0.5, np.nan]), 2: (np.int64(1), None)})
        {'lag': [0.5, None], '2': [1, None]}
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: as_json(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): as_json(each) for key, each in value.items()}
    if isinstance(value, (tuple, list)):
        return [as_json(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return as_json(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def fitted(value: object, schema: type[T]) -> T:
    """The value as one of a schema: a `msgspec.Struct`, a dataclass, or any type of those.

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
        raise DamagedDocumentError(_formatted(value, str(error))) from None


def _formatted(document: object, error: str) -> str:
    """The validator's words in ours: `Expected `int`, got `str` - at `$.a.b[0]``."""
    what, _, place = error.rpartition(" - at `$") if " - at `$" in error else (error, "", "")
    where = place.rstrip("`").lstrip(".")
    if missing := re.fullmatch(r"Object missing required field `(.*)`", what):
        return f"it has no entry {'.'.join(filter(None, [where, missing[1]]))!r}"
    name = f"its {where}" if where and "..." not in where else "an entry" if where else "it"
    expected = re.match(r"Expected `(.*?)`(?:, got `(.*)`| (.*))?", what)
    if what == "Number out of range":
        return f"{name} is {_value(document, where)}, which is too large"
    if expected is None:  # a part's own refusal, such as of a negative mass
        return f"{where}: {what}" if where else what
    wanted = " or ".join(_TYPES.get(kind, kind) for kind in expected[1].split(" | "))
    found = _value(document, where)
    if found is None or not where:
        found = _TYPES.get(expected[2] or "", expected[2] or "another")
    return f"{name} is {found}; it must be {wanted} {expected[3] or ''}".rstrip()


def _value(document: object, where: str) -> str | None:
    """The entry at a place such as `a.b[0]`, in short; None if the place has no name."""
    if "..." in where:
        return None
    for step in re.findall(r"[^.\[\]]+", where):
        entries = cast(dict[str, object], document)
        document = document[int(step)] if isinstance(document, list) else entries[step]
    return reprlib.repr(document)


def _require_text(text: str) -> None:
    for character in text:
        if not (character.isprintable() or character in "\t\n") and _harms(character):
            raise DamagedDocumentError(
                f"its text {reprlib.repr(text)} has the character {character!r}, which no text of "
                "such a file has"
            )


def _harms(character: str) -> bool:
    """Whether it is a control character, a half of one, or turns the direction of writing."""
    code = ord(character)
    turns = 0x202A <= code <= 0x202E or 0x2066 <= code <= 0x2069
    return code < 0x20 or 0x7F <= code < 0xA0 or 0xD800 <= code < 0xE000 or turns


CODE = "sha256"
"""The entry of a document that has the hash of a user's code."""


def differing(found: Json, wanted: Json) -> list[str]:
    """Names of what differs between two documents, such as `fitness.work` or `code of MyTerm`.

    Args:
        found: a document, JSON values.
        wanted: another one.

    Example:
        >>> differing({"seeds": 1, "body": {"mass_kg": 1}}, {"seeds": 1, "body": {"mass_kg": 2}})
        ['body.mass_kg']
        >>> differing({"kind": "MyTerm", "sha256": "a0"}, {"kind": "MyTerm", "sha256": "b1"})
        ['code of MyTerm']
    """
    names = _differing(_without_code(found), _without_code(wanted))
    theirs, ours = dict(_codes(found)), dict(_codes(wanted))
    edited = [each for each in {**theirs, **ours} if theirs.get(each) != ours.get(each)]
    # The code of a part that one of them lacks is not worth a word beside that.
    return names + [f"code of {x}" for x in edited if not names or (x in theirs and x in ours)]


def _codes(document: Json) -> Iterator[tuple[str, str]]:
    """The hashes of the code in a document, by what they are of."""
    if isinstance(document, list):
        for each in document:
            yield from _codes(each)
    if not isinstance(document, Mapping):
        return
    code = document.get(CODE)
    if isinstance(code, Mapping):
        yield from ((str(what), str(each)) for what, each in code.items())
    elif code is not None:
        names = (document.get(key) for key in ("kind", "name", "algorithm"))
        yield next((str(each) for each in names if each), "a part"), str(code)
    for each in document.values():
        yield from _codes(each)


def _without_code(document: Json) -> Json:
    if isinstance(document, list):
        return [_without_code(each) for each in document]
    if not isinstance(document, Mapping):
        return document
    return {name: _without_code(each) for name, each in document.items() if name != CODE}


def _differing(found: Json, wanted: Json, name: str = "") -> list[str]:
    if found == wanted:
        return []
    if isinstance(found, list) and isinstance(wanted, list) and len(found) == len(wanted):
        inside = (_differing(a, b, name) for a, b in zip(found, wanted, strict=True))
        return list(dict.fromkeys(each for names in inside for each in names))
    if not isinstance(found, Mapping) or not isinstance(wanted, Mapping):
        return [name]
    if name.endswith("controller") or found.get("kind") != wanted.get("kind"):
        return [name]
    names = [
        each
        for key in {**wanted, **found}
        for each in (
            _differing(found[key], wanted[key], f"{name}.{key}" if name else key)
            if key in found and key in wanted
            else [f"{name}.{key}" if name else key]
        )
    ]
    return [each.removeprefix("experiment.").removeprefix("system.") for each in names]
