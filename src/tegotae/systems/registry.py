"""The parts that documents may name, and objects of a user's own files.

A document names a part by its kind: one of this package, or one that a user registered. Reading a
document never imports anything: a kind that nobody registered is refused. Objects are named on the
command line, `FILE.py:OBJECT` or `MODULE:OBJECT`. A reference that a user names is followed; one in
a document is data, and is followed after `require_named` alone, which refuses all code that the
user has not named, too.
"""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import importlib.util
import os
import sys
import traceback
from collections.abc import Sequence
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any, TypeGuard, TypeVar, cast

from tegotae._support.documents import CODE
from tegotae._support.errors import TegotaeError, formatted, other_code, unknown
from tegotae._support.files import require_short
from tegotae._support.part_code import code_of
from tegotae.measures.metric import Metric

P = TypeVar("P")

_CONTRACTS = {
    "tegotae.parts.bodies": "Body",
    "tegotae.parts.oscillators": "Oscillator",
    "tegotae.parts.terms": "Term",
    "tegotae.parts.terrains": "Terrain",
    "tegotae.parts.couplings": "Coupling",
    "tegotae.simulation.integrators": "Integrator",
    "tegotae.simulation.world": "Condition",
    "tegotae.measures.objectives.objective": "Objective",
    "tegotae.training.algorithms": "Algorithm",
    "tegotae.training.agents": "AgentSettings",
}
"""Module of each contract, with the parts of this package that implement it."""
_MORE_PARTS = (
    "tegotae.measures.objectives.fitness",
    "tegotae.measures.objectives.walking",
)

_registered: dict[str, type] = {}
_codes: dict[type | tuple[type, str], str | None] = {}
"""The code of each registered part or metric as it was then, which is that of its file only until
this is edited."""


def register(part: P) -> P:
    """Let documents name a user's own part, so that it can be saved, loaded, trained and studied.

    A part is a frozen dataclass that keeps a contract: a subclass of `Body`, `Terrain`,
    `Oscillator`, `Term`, `Coupling`, `Integrator`, `Condition`, `Objective`, `Algorithm` or
    `AgentSettings`. It is named by its class. Registering it again, or a new version of the same
    class, is allowed; taking the name of another part is not. A `Metric` is registered so, too,
    and evaluated from then on.

    A text names a file or a module, as `--parts` does: it is imported, its parts are registered,
    and documents may refer to its objects.

    Args:
        part: the class, or an instance of it; of a metric the instance; or `FILE.py` or `MODULE`.

    Returns:
        the same, so that it serves as a decorator.

    Raises:
        TegotaeError: for what is no part, or has the name of another part; for a file or module
            that is not there or cannot be imported.

    Example:
        >>> from dataclasses import dataclass
        >>> from tegotae.parts.terms import VanillaAction
        >>> @register
        ... @dataclass(frozen=True)
        ... class LazyAction(VanillaAction):
        ...     '''The vanilla action by another name.'''
        >>> kinds()["LazyAction"] is LazyAction
        True
    """
    if isinstance(part, str):
        imported(part)
        return part
    if isinstance(part, Metric):
        if part.CATALOGUE.add(part):
            _codes[_key(part)] = code_of(getattr(part, "compute", type(part)))
        return part
    kind = part if isinstance(part, type) else type(part)
    contract = contract_of(kind)
    if contract is None:
        raise TegotaeError(
            f"{kind.__name__} is no part: a part is a subclass of one of "
            f"{', '.join(kept_contract.__name__ for kept_contract in contracts())}"
        )
    if not is_part(kind):
        raise TegotaeError(
            f"{kind.__name__} cannot be registered: it is no frozen dataclass; write "
            "@dataclass(frozen=True) above it"
        )
    fields = dataclasses.fields(kind)  # type: ignore[arg-type]
    if {"kind", CODE} & {field.name for field in fields}:
        raise TegotaeError(
            f"{kind.__name__} cannot be registered: documents call something else kind and {CODE}; "
            "give its field another name"
        )
    name = name_of(kind)
    previous = kinds().get(name)
    if previous is not None and _origin(previous) != _origin(kind):
        raise TegotaeError(
            f"{kind.__name__} cannot be registered: {previous.__module__} has a part called "
            f"{name} already; choose another name"
        )
    _registered[name] = kind
    if kind not in _codes:
        _codes[kind] = code_of(kind)
    return part


def kinds() -> dict[str, type]:
    """Return all registered parts by name, those of this package first."""
    return {**_package_parts(), **_registered}


def kinds_of(contract: type[P]) -> dict[str, type[P]]:
    """Return the registered parts that keep a contract, by name."""
    return {name: kind for name, kind in kinds().items() if issubclass(kind, contract)}


def name_of(kind: type) -> str:
    """Return the name of a part in documents and commands: its `NAME`, if it has one, or its
    class's name."""
    return vars(kind).get("NAME", kind.__name__)


def kind_of(part: object) -> str | None:
    """Return the name of a part's instance in documents; of other dataclasses their `NAME`, or
    None.

    Raises:
        TegotaeError: for a part that is not registered.
    """
    kind = type(part)
    if contract_of(kind) is None:
        return vars(kind).get("NAME")
    name = name_of(kind)
    registered = kinds().get(name)
    if registered is not kind:
        raise TegotaeError(
            f"a {kind.__name__} cannot be saved: it is not registered; "
            f"call tegotae.register({kind.__name__}) first"
        )
    return name


def code_noted(part: type | Metric) -> str | None:
    """Return the hash of the code of a user's part or metric when it was registered.

    It is None for this package's, and for a metric of no file.
    """
    return _codes.get(_key(part))


def _key(part: type | Metric) -> type | tuple[type, str]:
    return (type(part), part.name) if isinstance(part, Metric) else part


def is_part(kind: object) -> TypeGuard[type]:
    """Return whether a class implements a contract and can be serialised: a frozen dataclass."""
    return (
        isinstance(kind, type)
        and contract_of(kind) is not None
        and "__dataclass_params__" in vars(kind)
        and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    )


def contract_of(kind: type) -> type | None:
    """Return the contract that a class keeps, or is."""
    return next((contract for contract in contracts() if issubclass(kind, contract)), None)


@cache
def contracts() -> tuple[type, ...]:
    """Return the contracts that a part can keep."""
    return tuple(
        getattr(importlib.import_module(module), name) for module, name in _CONTRACTS.items()
    )


@cache
def _package_parts() -> dict[str, type]:
    """Return the parts of this package, by name."""
    modules = [importlib.import_module(name) for name in (*_CONTRACTS, *_MORE_PARTS)]
    parts = [part for module in modules for part in vars(module).values() if is_part(part)]
    return {name_of(part): part for part in parts if part not in contracts()}


def _origin(kind: type) -> tuple[str, str]:
    return kind.__module__, kind.__qualname__


def parts_in(value: object) -> list[object]:
    """Return all parts in a description (a dataclass, a tuple, a part), itself included."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inside = [getattr(value, field.name) for field in dataclasses.fields(value)]
        parts = [value] if contract_of(type(value)) is not None else []
        return parts + [part for entry in inside for part in parts_in(entry)]
    if isinstance(value, (tuple, list)):
        return [part for entry in cast(Sequence[object], value) for part in parts_in(entry)]
    return []


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
    """Return the object of a reference; import its file and register the parts in it.

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
    """Import a user's module, by its file or its name, and register its parts.

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
    """Return a place or a reference with the absolute path of its file."""
    place, dot_py, tail = text.rpartition(".py")
    return f"{Path(place).resolve()}{dot_py}{tail}" if tail[:1] in ("", ":") and place else text


def _imported(place: str) -> ModuleType:
    """Import a user's module and register its parts."""
    length = len(sys.path)
    try:
        module = _file(Path(place)) if place.endswith(".py") else _module(place)
    except TegotaeError:
        del sys.path[length:]
        raise
    for part in list(vars(module).values()):
        is_own_part = is_part(part) and part.__module__ == module.__name__
        if is_own_part or (isinstance(part, Metric) and part not in part.CATALOGUE.built_in):
            register(part)
    return module


def source_of(reference: str) -> Path | None:
    """Return the file that holds the object of a reference, or None if it is not known.

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
