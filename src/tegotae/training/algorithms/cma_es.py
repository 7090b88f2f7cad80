"""Covariance matrix adaptation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import jax
import jax.numpy as jnp

from tegotae._support.errors import require_count, require_finite
from tegotae.training.algorithms.base import Algorithm

if TYPE_CHECKING:
    from evosax.algorithms import CMA_ES


T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class CMAES(Algorithm):
    """CMA-ES with its standard settings (through evosax).

    Candidates are θ ~ N(μ, s² C); weighted by the ranks of their fitness, they move the mean μ, the
    step size s and the covariance C.

    It sets the BLAS libraries of this process to one thread.

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
        from threadpoolctl import threadpool_limits

        # As below: threads that wait for threads of the BLAS do so for ever, on two devices.
        threadpool_limits(limits=1, user_api="blas")
        return CMA_ES(self.population, jnp.zeros(n_weights))

    def of_seeds(self, function: Callable[..., T]) -> Callable[..., T]:
        """One seed after the other.

        The covariances of all seeds at once are decomposed by the threads of a pool that the
        devices share, and of two devices that wait for it neither goes on (jaxlib 0.10.2).
        """
        return lambda *arrays: jax.lax.map(lambda of_seed: function(*of_seed), arrays)

    def parameters(self, n_weights: int):
        """evosax's parameters."""
        defaults = self.strategy(n_weights).default_params
        return defaults.replace(std_init=jnp.asarray(self.std))
