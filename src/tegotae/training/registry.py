"""The learning algorithms by name: evolution strategies and agents, the package's and users'."""

from __future__ import annotations

from tegotae._support.errors import unknown
from tegotae.systems import registry
from tegotae.training.agents.settings import AgentSettings
from tegotae.training.algorithms import Algorithm


def evolutions() -> dict[str, type[Algorithm]]:
    """The registered evolution strategies by name."""
    return registry.kinds_of(Algorithm)


def agents() -> dict[str, type[AgentSettings]]:
    """The settings of the registered agents by name."""
    return registry.kinds_of(AgentSettings)


def learner(name: str) -> type[Algorithm] | type[AgentSettings]:
    """The algorithm of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> learner("cma-es").__name__
        'CMAES'
    """
    known = {**evolutions(), **agents()}
    if name not in known:
        raise unknown("algorithm", name, known)
    return known[name]
