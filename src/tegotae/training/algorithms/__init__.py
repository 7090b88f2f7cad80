"""Optimisers of controller weights, one file each."""

from tegotae.training.algorithms.base import Algorithm
from tegotae.training.algorithms.cma_es import CMAES
from tegotae.training.algorithms.open_es import OpenES
from tegotae.training.algorithms.pgpe import PGPE

ALGORITHMS: dict[str, type[Algorithm]] = {"pgpe": PGPE, "cma-es": CMAES, "openai-es": OpenES}
"""The algorithms by the name that `tegotae train --algorithm` takes."""

__all__ = ["ALGORITHMS", "CMAES", "PGPE", "Algorithm", "OpenES"]
