"""How documents name a learning algorithm: as commands do, beside its settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tegotae._support.documents import JsonObject
from tegotae.systems.descriptions import describe

if TYPE_CHECKING:
    from tegotae.training.agents.settings import AgentSettings
    from tegotae.training.algorithms.base import Algorithm


def algorithm_document(settings: Algorithm | AgentSettings) -> JsonObject:
    """Name and settings of an algorithm, a strategy's or an agent's, as JSON values.

    Raises:
        TegotaeError: for an algorithm that is not registered.

    Example:
        >>> from tegotae.training.algorithms import CMAES
        >>> algorithm_document(CMAES(population=8))
        {'name': 'cma-es', 'population': 8, 'std': 0.3}
    """
    document = describe(settings)
    return {"name": document.pop("kind"), **document}
