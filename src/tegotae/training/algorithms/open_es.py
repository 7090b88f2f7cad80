"""evosax's OpenAI-ES with its deviation as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
import optax
from evosax.algorithms import Open_ES

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.training.algorithms.base import Algorithm, with_hyperparameters

if TYPE_CHECKING:
    from evosax.algorithms import Open_ES


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

        optimizer = optax.inject_hyperparams(optax.adam)(learning_rate=self.learning_rate)
        return FixedDeviation(self.population, jnp.zeros(n_weights), optimizer=optimizer)

    def start(self, key: jax.Array, weights: jax.Array):
        """State of a search that starts from `weights`, with its deviation and Adam's step size."""
        state = super().start(key, weights)
        optimizer = {**state.opt_state.hyperparams, "learning_rate": self.learning_rate}
        state = with_hyperparameters(state, **optimizer)
        return state.replace(std=jnp.asarray(self.std, "float32"))
