"""evosax's OpenAI-ES with its deviation as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
from evosax.algorithms import Open_ES

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.training.algorithms.base import Adjustable, Algorithm, with_settings

if TYPE_CHECKING:
    from evosax.algorithms import Open_ES


class Moments(NamedTuple):
    """What Adam keeps: the number of updates, and the means of the gradient and of its square."""

    updates: jax.Array
    first: jax.Array
    second: jax.Array


@dataclass(frozen=True)
class Adam:
    """Adam with its standard decays, of a learning rate that may be traced.

    Reference: D. P. Kingma and J. Ba, Adam: a method for stochastic optimization, 2015.
    """

    learning_rate: float | jax.Array

    def init(self, means: jax.Array) -> Moments:
        """The state before the first update."""
        return Moments(jnp.zeros((), "int32"), jnp.zeros_like(means), jnp.zeros_like(means))

    def update(
        self, gradient: jax.Array, state: Moments, means: jax.Array | None = None
    ) -> tuple[jax.Array, Moments]:
        """The step of the means, and the state after it."""
        slow, slower, least = (jnp.asarray(x, "float32") for x in (0.9, 0.999, 1e-8))
        count = state.updates + 1
        first = (1 - slow) * gradient + slow * state.first
        second = (1 - slower) * gradient**2 + slower * state.second
        deviation = jnp.sqrt(second / (1 - slower**count))
        step = first / (1 - slow**count) / (deviation + least)
        return -self.learning_rate * step, Moments(count, first, second)


class FixedDeviation(Open_ES):
    """OpenAI-ES that keeps the deviation in its state: evosax's is a part of the program."""

    def _tell(self, key, population, fitness, state, params):
        return super()._tell(key, population, fitness, state, params).replace(std=state.std)


@dataclass(frozen=True, kw_only=True)
class OpenES(Algorithm):
    """OpenAI-ES: antithetic pairs, centred ranks, Adam, a fixed deviation (through evosax).

    With samples `θ± = μ ± σ ε`, ε ~ N(0, 1), and centred ranks r of their fitness, Adam moves μ
    along `∇μ = Σ (r₊ - r₋) ε / (n σ)`.

    Raises:
        TegotaeError: for an odd population or a setting out of its range.

    Reference: T. Salimans et al., Evolution strategies as a scalable alternative to reinforcement
    learning, 2017.
    """

    NAME = "openai-es"

    population: int = 64
    """Episodes per generation: an even number."""
    std: float = 0.2
    """Standard deviation of every weight."""
    learning_rate: float = 0.05
    """Adam's step size."""

    def __post_init__(self) -> None:
        require_count("population", self.population, least=2)
        if self.population % 2:
            raise TegotaeError(
                f"population is {self.population}; OpenAI-ES samples pairs, so it must be even"
            )
        require_finite("std", self.std, above=0.0)
        require_finite("learning_rate", self.learning_rate, above=0.0)

    @property
    def program(self) -> OpenES:
        """The population alone."""
        return OpenES(population=self.population)

    def make(self, n_weights: int) -> Open_ES:
        """evosax's OpenAI-ES."""

        optimizer: Any = Adjustable(Adam, {"learning_rate": self.learning_rate})
        return FixedDeviation(self.population, jnp.zeros(n_weights), optimizer=optimizer)

    def start(self, key: jax.Array, weights: jax.Array):
        """State of a search that starts from `weights`, with its deviation and Adam's step size."""
        state = super().start(key, weights)
        state = with_settings(state, learning_rate=self.learning_rate)
        return state.replace(std=jnp.asarray(self.std, "float32"))
