"""Policy gradients with parameter-based exploration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.training.algorithms.base import Adjustable, Algorithm, with_settings

if TYPE_CHECKING:
    from evosax.algorithms import PGPE as EvosaxPGPE  # noqa: N811


@dataclass(frozen=True, kw_only=True)
class PGPE(Algorithm):
    """PGPE with antithetic pairs, centred ranks and ClipUp, as in the paper (through evosax).

    With samples `θ± = μ ± ε`, ε ~ N(0, σ²), and centred ranks r of their fitness:

        ∇μ = Σ (r₊ - r₋) ε / n,    ∇σ = Σ (r₊ + r₋ - 2 r̄)(ε² - σ²)/σ / n,

    μ moves by ClipUp, σ by at most a share `std_max_change` of itself.

    Raises:
        TegotaeError: for an odd population or a setting out of its range.

    References:
        F. Sehnke et al., Parameter-exploring policy gradients, Neural Networks 23, 2010.
        N. E. Toklu et al., ClipUp, PPSN 2020.
    """

    NAME = "pgpe"

    population: int = 64
    """Episodes per generation: an even number."""
    std: float = 0.3
    """Initial standard deviation of every weight."""
    std_lr: float = 0.1
    """Learning rate of the standard deviations."""
    std_max_change: float = 0.2
    """Largest share by which a standard deviation changes in a generation."""
    learning_rate: float = 0.2
    """ClipUp's step size."""
    max_speed: float = 0.4
    """ClipUp's largest step."""
    momentum: float = 0.9
    """ClipUp's momentum."""

    def __post_init__(self) -> None:
        require_count("population", self.population, least=2)
        if self.population % 2:
            raise TegotaeError(
                f"population is {self.population}; PGPE samples pairs, so it must be even"
            )
        for name in ("std", "learning_rate", "max_speed"):
            require_finite(name, getattr(self, name), above=0.0)
        for name in ("std_lr", "std_max_change", "momentum"):
            require_finite(name, getattr(self, name), least=0.0)

    @property
    def program(self) -> PGPE:
        """The population alone."""
        return PGPE(population=self.population)

    def make(self, n_weights: int) -> EvosaxPGPE:
        """evosax's PGPE."""
        from evosax.algorithms import PGPE as EvosaxPGPE  # noqa: N811
        from evosax.core.optimizer import clipup

        optimizer: Any = Adjustable(clipup, self._clipup)
        return EvosaxPGPE(self.population, jnp.zeros(n_weights), optimizer=optimizer)

    def parameters(self, n_weights: int):
        """evosax's parameters."""
        return self.strategy(n_weights).default_params.replace(
            std_init=self.std, std_lr=self.std_lr, std_max_change=self.std_max_change
        )

    def start(self, key: jax.Array, weights: jax.Array):
        """State of a search that starts from `weights`, with ClipUp's settings."""
        return with_settings(super().start(key, weights), **self._clipup)

    @property
    def _clipup(self) -> dict[str, float]:
        return {
            "learning_rate": self.learning_rate,
            "max_velocity": self.max_speed,
            "momentum": self.momentum,
        }
