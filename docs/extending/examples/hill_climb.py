"""A learning algorithm: keep the best of some random neighbours."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts import require_count, require_finite
from tegotae.training.algorithms import Algorithm


class ClimbState(NamedTuple):
    """Where the search is. Every strategy's state has a mean and a std."""

    mean: jax.Array
    std: jax.Array
    fitness: jax.Array


@dataclass(frozen=True)
class Climber:
    """The strategy: pure functions of arrays. It minimises."""

    population: int
    step: float
    default_params: tuple = ()

    def init(self, key, mean, parameters) -> ClimbState:
        """The state at the first weights."""
        return ClimbState(mean, jnp.asarray(self.step, mean.dtype), jnp.asarray(jnp.inf))

    def ask(self, key, state, parameters):
        """Samples to try, shape [population, n_weights], and the state."""
        noise = jax.random.normal(key, (self.population, state.mean.shape[0]))
        return state.mean[None] + state.std * noise, state

    def tell(self, key, samples, fitness, state, parameters):
        """The state once the samples have been evaluated, and further metrics."""
        best = jnp.argmin(fitness)
        mean = jnp.where(fitness[best] < state.fitness, samples[best], state.mean)
        return ClimbState(mean, state.std, jnp.minimum(fitness[best], state.fitness)), {}


@dataclass(frozen=True, kw_only=True)
class HillClimb(Algorithm):
    """The settings."""

    NAME = "hill-climb"  # what commands and documents call it

    population: int = 16
    step: float = 0.2

    def __post_init__(self) -> None:
        require_count("population", self.population)
        require_finite("step", self.step, above=0.0)

    def make(self, n_weights: int) -> Climber:
        """The strategy for so many weights."""
        return Climber(self.population, self.step)
