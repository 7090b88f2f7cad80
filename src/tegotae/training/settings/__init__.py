"""Named configurations: settings of the algorithms that were found by tuning, and how.

Each is a file of this folder, as `python -m studies.tuning --keep` writes it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import msgspec

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError, unknown
from tegotae.systems.descriptions import restore
from tegotae.training.agents.settings import AgentSettings
from tegotae.training.algorithms import Algorithm
from tegotae.training.registry import learner


class _SettingsFile(msgspec.Struct):
    algorithm: str
    settings: dict[str, object]
    found: dict[str, object]


@dataclass(frozen=True)
class Configuration:
    """Settings of an algorithm, and how they were found."""

    algorithm: str
    """The algorithm's name, as `tegotae train --algorithm` takes it."""
    settings: Algorithm | AgentSettings
    """Its settings."""
    found: Mapping[str, object]
    """On what, by how many trials, how good; see `studies.tuning.describe`."""


def names() -> list[str]:
    """Names of the configurations that come with the package."""
    files = resources.files(__name__).iterdir()
    return sorted(file.name[:-5] for file in files if file.name.endswith(".json"))


def configuration(name: str) -> Configuration:
    """The named configuration that comes with the package.

    Raises:
        TegotaeError: for an unknown name.
    """
    if name not in names():
        raise unknown("configuration", name, names())
    return _read(resources.files(__name__) / f"{name}.json")


def load(path: Path | str) -> Configuration:
    """A configuration that `python -m studies.tuning --keep` wrote.

    Raises:
        TegotaeError: if the file cannot be read, or holds no settings of a known algorithm.
    """
    return _read(Path(path))


def tuned(algorithm: str) -> Any:
    """The tuned settings of an algorithm; those of its class where none are kept.

    Raises:
        TegotaeError: for an unknown algorithm.

    Example:
        >>> tuned("cma-es").population > 0
        True
    """
    kind = learner(algorithm)
    return configuration(algorithm).settings if algorithm in names() else kind()


def _read(file: Path | Traversable) -> Configuration:
    try:
        found = documents.fitted(documents.read(file), _SettingsFile)
        kind = learner(found.algorithm)
    except FileNotFoundError as error:
        raise TegotaeError(f"cannot read {file}: {error.strerror}") from None
    except DamagedDocumentError as error:
        raise TegotaeError(
            f"{file} is no configuration that python -m studies.tuning --keep wrote: {error}"
        ) from None
    except TegotaeError as error:
        raise TegotaeError(f"{file} is no configuration known here: {error}") from None
    names = [field.name for field in dataclasses.fields(kind)]
    if others := [name for name in found.settings if name not in names]:
        raise TegotaeError(f"{file} has settings that {found.algorithm} does not have: {others[0]}")
    try:
        contract = Algorithm if issubclass(kind, Algorithm) else AgentSettings
        settings = restore({"kind": found.algorithm, **found.settings}, contract, "settings")
    except (KeyError, TypeError, ValueError) as error:
        raise TegotaeError(f"{file} is damaged: in its settings, {error}") from None
    return Configuration(found.algorithm, settings, found.found)
