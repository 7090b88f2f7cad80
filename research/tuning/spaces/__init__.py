"""Search spaces, one file per algorithm."""

from research.tuning.spaces import (
    cma_es,
    open_es,
    pgpe,
    ppo,
    sac,
    snes,
)
from research.tuning.spaces.agent import learned
from research.tuning.spaces.base import Space
from research.tuning.spaces.population import evolved
from tegotae._support.errors import TegotaeError, unknown
from tegotae.training import settings as learners
from tegotae.training.algorithms import Algorithm

SPACES: dict[str, Space] = {
    "pgpe": pgpe.SPACE,
    "cma-es": cma_es.SPACE,
    "openai-es": open_es.SPACE,
    "snes": snes.SPACE,
    "sac": sac.SPACE,
    "ppo": ppo.SPACE,
}
"""The spaces of the package's algorithms, by the name that `--algorithm` takes."""


def space_of(algorithm: str) -> Space:
    """Return the search space of an algorithm: the package's, or that of a user's algorithm.

    An evolution strategy of a user's own says so by two attributes of its class: `suggest`, a
    static method from an Optuna trial to its settings, and `FIRST`, the parameters tried first.

    Raises:
        TegotaeError: for an unknown algorithm, or one that does not say what may be tried.

    Example:
        >>> space_of("cma-es").first["std"]
        0.3
    """
    if algorithm in SPACES:
        return SPACES[algorithm]
    kind = {**learners.evolutions(), **learners.agents()}.get(algorithm)
    if kind is None:
        raise unknown("algorithm", algorithm, [*SPACES, *learners.evolutions()])
    if not hasattr(kind, "suggest") or not hasattr(kind, "FIRST"):
        raise TegotaeError(
            f"{algorithm} does not say what may be tried; give {kind.__name__} a static method "
            "suggest(trial) and FIRST, the parameters tried first"
        )
    learn = evolved if issubclass(kind, Algorithm) else learned
    return Space(suggest=kind.suggest, learn=learn, first=kind.FIRST)  # type: ignore[attr-defined]


__all__ = ["SPACES", "Space", "space_of"]
