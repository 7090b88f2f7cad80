"""Optimisers of controller weights, one file each."""

from tegotae.training.algorithms.base import Algorithm
from tegotae.training.algorithms.cma_es import CMAES
from tegotae.training.algorithms.open_es import OpenES
from tegotae.training.algorithms.pgpe import PGPE

__all__ = ["CMAES", "PGPE", "Algorithm", "OpenES"]
