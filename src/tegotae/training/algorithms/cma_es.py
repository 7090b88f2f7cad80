"""Covariance matrix adaptation."""

from __future__ import annotations

import ctypes
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

    It sets SciPy's BLAS, with which JAX decomposes, to one thread in this process.

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

        _use_one_blas_thread()
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


def _use_one_blas_thread() -> None:
    """Devices whose threads wait for those of the BLAS do so for ever, where there are two."""
    from scipy.linalg import cython_lapack  # type: ignore[attr-defined]

    library = ctypes.CDLL(cython_lapack.__file__)  # Its symbols include those that it is linked to.
    for name in ("scipy_openblas_set_num_threads", "openblas_set_num_threads"):
        if hasattr(library, name):
            getattr(library, name)(1)
