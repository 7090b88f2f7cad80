"""What a black-box optimiser of controller weights is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import jax


class Algorithm(ABC):
    """An optimiser of weights from episode fitness alone: a frozen dataclass of its settings.

    It wraps an evosax strategy. Strategies minimise; the trainer hands them the negative fitness.
    """

    population: int
    """Episodes per generation and seed."""

    @abstractmethod
    def strategy(self, n_weights: int) -> Any:
        """The evosax strategy for this many weights. Cached: a new instance compiles anew."""

    @abstractmethod
    def parameters(self, n_weights: int) -> Any:
        """The strategy's parameters."""

    def start(self, key: jax.Array, weights: jax.Array) -> Any:
        """State of a search that starts from `weights`, shape [n_weights]."""
        n = weights.shape[0]
        return self.strategy(n).init(key, weights, self.parameters(n))
