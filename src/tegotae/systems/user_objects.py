"""Objects of a user's own files, named on the command line: `FILE.py:OBJECT` or `MODULE:OBJECT`.

A reference that a user names is followed. One in a document is data: it is followed after
`require_named` alone, which refuses all code that the user has not named, too.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import sys
import traceback
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from tegotae._support.errors import TegotaeError, formatted, other_code, unknown
from tegotae._support.files import require_short
from tegotae.measures.metric import Metric
from tegotae.systems import registry

_loaded: set[str] = set()
"""Files, modules and references that the user of this process named."""


def is_reference(text: str) -> bool:
    """Return whether a word names an object of a user's own file.

    Example:
        >>> is_reference("my_parts.py:experiment"), is_reference("ART-rF-tphif-w8")
        (True, False)
    """
    return ":" in text


def load_object(reference: str, kind: type | tuple[type, ...], role: str) -> Any:
    """The object of a reference; its file is imported, and the parts in it are registered.

    A class is taken for an instance of it with its defaults.

    Args:
        reference: `FILE.py:OBJECT` or `MODULE:OBJECT`.
        kind: what the object must be an instance of.
        role: what is asked for, for errors, such as "body".

    Raises:
        TegotaeError: if there is no such file, module or object, if the file cannot be imported, or
            if the object is something else.
    """
    place, _, name = reference.rpartition(":")
    if not place or not name:
        raise TegotaeError(f"{reference!r} names no {role}; write FILE.py:OBJECT or MODULE:OBJECT")
    module = _imported(place)
    _loaded.add(_absolute(reference))
    if not hasattr(module, name):
        raise unknown(f"object of {place}", name, [n for n in vars(module) if n[0] != "_"])
    value = getattr(module, name)
    kinds = kind if isinstance(kind, tuple) else (kind,)
    if isinstance(value, type) and issubclass(value, kinds):
        with other_code(f"{reference} cannot be made"):
            value = value()
    if not isinstance(value, kinds):
        names = " or ".join(candidate.__name__ for candidate in kinds)
        cls = value if isinstance(value, type) else type(value)
        raise TegotaeError(f"{reference} is no {role}: it is a {cls.__name__}, no {names}")
    return value


def imported(place: str) -> ModuleType:
    """A user's module, by its file or its name, with its parts registered.

    The folder of a file is added to the path, so that worker processes find it, too. From then on
    documents may refer to its objects.

    Raises:
        TegotaeError: if it is not there or cannot be imported.
    """
    module = _imported(place)
    _loaded.add(_absolute(place))
    return module


def require_named(text: str, document: str) -> None:
    """Refuse a text of a document that refers to code, unless the user named that code.

    The code is named by `imported` (`--parts`, `tegotae.register`), or by the same reference.

    Args:
        text: an entry of the document that may be a reference.
        document: what it is an entry of, for the error.

    Raises:
        TegotaeError: for a reference that the user did not name.

    Example:
        >>> require_named("Hopper-v5", "leg.json")
        >>> require_named("evil.py:run", "leg.json")
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: leg.json refers to code, 'evil.py:run', which ...
    """
    place = text.rpartition(":")[0]
    if is_reference(text) and not {_absolute(text), _absolute(place)} & _loaded:
        raise TegotaeError(
            f"{document} refers to code, {text!r}, which no file may run by itself; if you trust "
            f"that code, add --parts {place}, or tegotae.register({place!r})"
        )


def _absolute(text: str) -> str:
    """A place or a reference, the file in it by its absolute path."""
    place, dot_py, tail = text.rpartition(".py")
    return f"{Path(place).resolve()}{dot_py}{tail}" if tail[:1] in ("", ":") and place else text


def _imported(place: str) -> ModuleType:
    """A user's module, with its parts registered."""
    length = len(sys.path)
    try:
        module = _file(Path(place)) if place.endswith(".py") else _module(place)
    except TegotaeError:
        del sys.path[length:]
        raise
    for part in list(vars(module).values()):
        is_own_part = registry.is_part(part) and part.__module__ == module.__name__
        if is_own_part or (isinstance(part, Metric) and part not in part.CATALOGUE.built_in):
            registry.register(part)
    return module


def source_of(reference: str) -> Path | None:
    """The file in which the object of a reference is; None if it is not known.

    Example:
        >>> source_of("json:loads").name, source_of("nowhere.py:body")
        ('__init__.py', None)
    """
    place = reference.rpartition(":")[0]
    if place.endswith(".py"):
        return Path(place) if Path(place).is_file() else None
    spec = _spec(place)
    return Path(spec.origin) if spec and spec.origin and spec.has_location else None


def _file(path: Path) -> ModuleType:
    require_short(path)
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    path, name = path.resolve(), path.stem
    if not name.isidentifier():
        raise TegotaeError(
            f"{path.name} cannot be imported: name it with letters, digits and _ alone"
        )
    spec = _spec(name)
    if spec is not None and (spec.origin is None or Path(spec.origin).resolve() != path):
        raise TegotaeError(
            f"{path.name} cannot be imported: there is a module {name} already "
            f"({spec.origin or 'built in'}); give the file another name"
        )
    _add_to_path(path.parent)
    return _import(name, str(path))


def _module(name: str) -> ModuleType:
    _add_to_path(Path.cwd())  # where a console script does not look by itself
    spec = _spec(name)
    if spec is None or spec.origin is None:  # a folder without code is a module to Python
        raise TegotaeError(f"there is no module {name}; for a file write FILE.py:OBJECT")
    return _import(name, name)


def _spec(name: str) -> ModuleSpec | None:
    with contextlib.suppress(ImportError, ValueError):
        return importlib.util.find_spec(name)
    return None


def _add_to_path(folder: Path) -> None:
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
        importlib.invalidate_caches()


def _import(name: str, place: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except TegotaeError as error:
        raise TegotaeError(f"{place} cannot be imported: {error}") from None
    except (Exception, SystemExit) as error:  # anything may go wrong in a user's file
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == place]
        line = getattr(error, "lineno", None) or (frames[-1].lineno if frames else None)
        where = "" if line is None else f", line {line}"
        raise TegotaeError(
            f"{os.path.basename(place)} cannot be imported{where}: {formatted(error)}"
        ) from None
