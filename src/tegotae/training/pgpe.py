"""PGPE's search distribution: its samples, and its step by the ranks of their fitness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

_LEAST_LENGTH = 1e-8
"""Is added to the length of a gradient, which may be zero."""


class PGPESettings(NamedTuple):
    """Numbers of the search; another value of them compiles nothing anew."""

    std: float
    """Initial standard deviation of every weight."""
    std_lr: float
    """Learning rate of the standard deviations."""
    std_max_change: float
    """Largest share by which a standard deviation changes in a generation."""
    learning_rate: float
    """ClipUp's step size."""
    max_speed: float
    """ClipUp's largest step."""
    momentum: float
    """ClipUp's momentum."""


class PGPEState(NamedTuple):
    """The search distribution, and how it moves; arrays [n_weights]."""

    mean: jax.Array
    std: jax.Array
    velocity: jax.Array
    """ClipUp's velocity, in step sizes."""


@dataclass(frozen=True)
class PGPESearch:
    """PGPE with antithetic pairs, centred ranks and ClipUp, as pure functions of arrays.

    Args:
        population: samples of a generation; an even number.
    """

    population: int

    def init(self, key: jax.Array, mean: jax.Array, settings: PGPESettings) -> PGPEState:
        """Return the state of a search that starts from a mean."""
        return PGPEState(mean, jnp.full_like(mean, settings.std), jnp.zeros_like(mean))

    def ask(
        self, key: jax.Array, state: PGPEState, settings: PGPESettings
    ) -> tuple[jax.Array, PGPEState]:
        """Return samples [population, n_weights], first μ + ε and then μ - ε, and the state."""
        normal = jax.random.normal(key, (self.population // 2, *state.mean.shape))
        return state.mean[None] + state.std[None] * jnp.concatenate([normal, -normal]), state

    def tell(
        self,
        key: jax.Array,
        samples: jax.Array,
        loss: jax.Array,
        state: PGPEState,
        settings: PGPESettings,
    ) -> tuple[PGPEState, None]:
        """Return the state after a step to smaller losses.

        Args:
            key: is not used.
            samples: as `ask` returned them.
            loss: of every sample, [population]; NaN is the largest.
            state: as `ask` returned it.
            settings: numbers of the search.
        """
        pairs = self.population // 2
        mean, std = state.mean, state.std
        rank = centred_ranks(loss)
        plus, minus = rank[:pairs], rank[pairs:]
        epsilon = samples[:pairs] - mean[None]
        to_mean = (plus - minus) @ epsilon / self.population
        spread = (epsilon**2 - (std**2)[None]) / std[None]
        to_std = (plus + minus - 2.0 * rank.mean()) @ spread / self.population

        step = to_mean / (_length(to_mean) + _LEAST_LENGTH)
        velocity = settings.momentum * state.velocity + step
        speed = _length(velocity)
        shorter = settings.max_speed / (settings.learning_rate * speed)
        is_quick = speed > settings.max_speed / settings.learning_rate
        velocity = velocity * jnp.where(is_quick, shorter, 1.0)

        change = settings.std_max_change * std
        wished = std - settings.std_lr * to_std
        return PGPEState(
            mean - settings.learning_rate * velocity,
            jnp.clip(wished, std - change, std + change),
            velocity,
        ), None


def centred_ranks(loss: jax.Array) -> jax.Array:
    """Return ranks from -1/2, the smallest loss, to 1/2; equals share their mean rank.

    Args:
        loss: [population]; NaN is the largest.

    Example:
        >>> centred_ranks(jnp.array([3.0, 1.0, 3.0, 2.0, jnp.nan])).tolist()
        [0.125, -0.5, 0.125, -0.25, 0.5]
    """
    loss = jnp.where(jnp.isnan(loss), jnp.inf, loss)
    ours, others = loss[:, None], loss[None, :]
    smaller = (others < ours).sum(axis=1, dtype=loss.dtype)
    equal = (others == ours).sum(axis=1, dtype=loss.dtype)
    return (smaller + 0.5 * (equal - 1.0)) / (len(loss) - 1) - 0.5


def _length(vector: jax.Array) -> jax.Array:
    return jnp.sqrt((vector**2).sum())
