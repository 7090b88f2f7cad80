"""Covariance matrix adaptation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import jax.numpy as jnp

from tegotae.errors import require_count, require_finite
from tegotae.training.algorithms.base import Algorithm

if TYPE_CHECKING:
    from evosax.algorithms import CMA_ES


@dataclass(frozen=True, kw_only=True)
class CMAES(Algorithm):
    """CMA-ES with its standard settings (through evosax).

    Raises:
        TegotaeError: for a setting out of its range.

    Reference: N. Hansen, The CMA evolution strategy: a tutorial, 2016.
    """

    NAME = "cma-es"

    population: int = 64
    """Episodes per generation."""
    std: float = 0.3
    """Initial step size, the standard deviation of every weight."""

    def __post_init__(self) -> None:
        require_count("population", self.population, least=4)
        require_finite("std", self.std, above=0.0)

    @property
    def program(self) -> CMAES:
        """The population alone."""
        return CMAES(population=self.population)

    def make(self, n_weights: int) -> CMA_ES:
        """evosax's CMA-ES."""
        from evosax.algorithms import CMA_ES

        return CMA_ES(self.population, jnp.zeros(n_weights))

    def parameters(self, n_weights: int):
        """evosax's parameters."""
        defaults = self.strategy(n_weights).default_params
        return defaults.replace(std_init=jnp.asarray(self.std))
