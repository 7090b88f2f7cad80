"""Optimisers of controller weights, one file each."""

from tegotae.training.algorithms.base import Algorithm
from tegotae.training.algorithms.pgpe import PGPE

ALGORITHMS: dict[str, type[Algorithm]] = {"pgpe": PGPE}

__all__ = ["ALGORITHMS", "PGPE", "Algorithm"]
