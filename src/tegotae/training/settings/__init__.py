"""The learning algorithms by name, the package's and users', and settings found by tuning.

Each named configuration is a file of this folder: algorithm, settings, and their origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import msgspec

from tegotae._support import documents
from tegotae._support.errors import TegotaeError, lookup, require_known
from tegotae.systems import registry
from tegotae.systems.descriptions import restore
from tegotae.systems.registry import is_reference, load_object
from tegotae.training.agents import AgentSettings
from tegotae.training.algorithms import Algorithm

Settings = Algorithm | AgentSettings


def evolutions() -> dict[str, type[Algorithm]]:
    """Return the registered evolution strategies by name."""
    return registry.kinds_of(Algorithm)


def agents() -> dict[str, type[AgentSettings]]:
    """Return the settings of the registered agents by name."""
    return registry.kinds_of(AgentSettings)


def learner(name: str) -> type[Algorithm] | type[AgentSettings]:
    """Return the algorithm of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> learner("cma-es").__name__
        'CMAES'
    """
    learners = {**evolutions(), **agents()}
    return lookup("algorithm", name, learners)


class _SettingsFile(msgspec.Struct):
    algorithm: str
    settings: dict[str, object]
    found: dict[str, object]


@dataclass(frozen=True)
class Configuration:
    """Settings of an algorithm, and how they were found."""

    algorithm: str
    """The algorithm's name, as `tegotae train --algorithm` takes it."""
    settings: Settings
    """Its settings."""
    found: Mapping[str, object]
    """Origin of the settings: the problem, the number of trials, the score."""


def configuration_names() -> list[str]:
    """Return the names of the configurations that come with the package."""
    files = resources.files(__name__).iterdir()
    return sorted(file.name[:-5] for file in files if file.name.endswith(".json"))


def configuration(name: str) -> Configuration:
    """Return the named configuration that comes with the package.

    Raises:
        TegotaeError: for an unknown name.
    """
    require_known("configuration", name, configuration_names())
    return load_configuration(resources.files(__name__) / f"{name}.json")


def load_configuration(file: Path | str | Traversable) -> Configuration:
    """Return the configuration of a file.

    Raises:
        TegotaeError: if the file cannot be read, or holds no settings of a known algorithm.
    """
    file = Path(file) if isinstance(file, str) else file
    try:
        entries = documents.fitted(documents.read(file), _SettingsFile)
        document = {"kind": entries.algorithm, **entries.settings}
        settings = restore(document, Settings, "settings")
    except FileNotFoundError as error:
        raise TegotaeError(f"cannot read {file}: {error.strerror}") from None
    except TegotaeError as error:
        raise TegotaeError(f"{file} holds no settings of an algorithm: {error}") from None
    return Configuration(entries.algorithm, settings, entries.found)


def tuned(algorithm: str) -> Any:
    """Return the tuned settings of an algorithm, or its class's defaults if none are kept.

    Raises:
        TegotaeError: for an unknown algorithm.

    Example:
        >>> tuned("cma-es").population > 0
        True
    """
    kind = learner(algorithm)
    return configuration(algorithm).settings if algorithm in configuration_names() else kind()


def settings_named(name: str, contracts: Any = (Algorithm, AgentSettings)) -> Any:
    """Return the settings of an algorithm: the tuned ones, or those of a user's file.

    Args:
        name: such as pgpe, in any letters, or `FILE.py:OBJECT`.
        contracts: the contracts, one of which it must keep.

    Raises:
        TegotaeError: for an unknown name, or an algorithm of another kind.
    """
    if is_reference(name):
        return load_object(name, contracts, "algorithm")
    if not isinstance(settings := tuned(name.lower()), contracts):
        raise TegotaeError(f"{name} cannot be used here; it needs an evolution strategy like pgpe")
    return settings
