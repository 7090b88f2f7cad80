"""How documents name a learning algorithm: as commands do, beside its settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tegotae.systems.descriptions import describe

_EARLIER_NAMES = {"cmaes": "cma-es", "CMAES": "cma-es", "openes": "openai-es", "PGPE": "pgpe"}
"""What earlier versions wrote for some algorithms."""


def algorithm_document(settings: Any) -> dict[str, Any]:
    """Name and settings of an algorithm, a strategy's or an agent's, as JSON values.

    Raises:
        TegotaeError: for an algorithm that is not registered.

    Example:
        >>> from tegotae.training.algorithms import CMAES
        >>> algorithm_document(CMAES(population=8))
        {'name': 'cma-es', 'population': 8, 'std': 0.3}
    """
    document: dict[str, Any] = describe(settings)
    return {"name": document.pop("kind"), **document}


def algorithm_name(document: Mapping[str, Any]) -> str:
    """The algorithm's name in a document of this version or an earlier one."""
    name: str = document["name"]
    return _EARLIER_NAMES.get(name, name)
