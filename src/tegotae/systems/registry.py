"""The parts that documents may name: those of this package, and those that a user registered.

A document names a part by its kind. Reading one never imports anything: a kind that nobody
registered is refused, and so is a reference to code (`tegotae.systems.user_objects`).
"""

from __future__ import annotations

import dataclasses
import importlib
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TypeGuard, TypeVar, cast

from tegotae._support.documents import CODE
from tegotae._support.errors import TegotaeError
from tegotae._support.part_code import code_of, code_of_file
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
        from tegotae.systems.user_objects import imported  # which registers parts itself

        imported(part)
        return part
    if isinstance(part, Metric):
        if part.CATALOGUE.add(part):
            _codes[_key(part)] = _code_of_metric(part)
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
    """All registered parts by name, those of this package first."""
    return {**_package_parts(), **_registered}


def kinds_of(contract: type[P]) -> dict[str, type[P]]:
    """The registered parts that keep a contract, by name."""
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


def _code_of_metric(metric: Metric) -> str | None:
    """Return the hash of the file with a metric's function."""
    module = getattr(getattr(metric, "compute", None), "__module__", None) or ""
    file = getattr(sys.modules.get(module), "__file__", None)
    return code_of_file(Path(file), module) if file and Path(file).is_file() else None


def is_part(kind: object) -> TypeGuard[type]:
    """Return whether a class implements a contract and can be serialised: a frozen dataclass."""
    return (
        isinstance(kind, type)
        and contract_of(kind) is not None
        and "__dataclass_params__" in vars(kind)
        and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    )


def contract_of(kind: type) -> type | None:
    """The contract that a class keeps, or is."""
    return next((contract for contract in contracts() if issubclass(kind, contract)), None)


@cache
def contracts() -> tuple[type, ...]:
    """The contracts that a part can keep."""
    return tuple(
        getattr(importlib.import_module(module), name) for module, name in _CONTRACTS.items()
    )


@cache
def _package_parts() -> dict[str, type]:
    """The parts of this package, by name."""
    modules = [importlib.import_module(name) for name in (*_CONTRACTS, *_MORE_PARTS)]
    parts = [part for module in modules for part in vars(module).values() if is_part(part)]
    return {name_of(part): part for part in parts if part not in contracts()}


def _origin(kind: type) -> tuple[str, str]:
    return kind.__module__, kind.__qualname__


def parts_in(value: object) -> list[object]:
    """All parts that a description (a dataclass, a tuple, a part) is made of, itself included."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inside = [getattr(value, field.name) for field in dataclasses.fields(value)]
        parts = [value] if contract_of(type(value)) is not None else []
        return parts + [part for entry in inside for part in parts_in(entry)]
    if isinstance(value, (tuple, list)):
        return [part for entry in cast(Sequence[object], value) for part in parts_in(entry)]
    return []
