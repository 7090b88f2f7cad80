"""How much of the force does not follow the spring force.

Source: of this library, for the paper's "independence of the actuation instant from the oscillator
state, while the actuation force is solely modulated by F_k" (V).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.episode import Episode
from tegotae.measures.hopping.metric import REPORT, GaitMetric

_BINS = 12
"""Of the spring force, from zero to its largest; in each of them the force may follow a line."""

_STILL = 1e-3
"""A force that varies less than this, over its own size, has no variance to be explained."""


def _compute(episode: Episode) -> jax.Array:
    """The force's variance left beside a line in each of 12 bins of F_k, over its whole variance.

    All in stance of the settled part: about E[Var(F_a | F_k)] / Var(F_a).

    On a limit cycle the force is a function of the place in the cycle. What it has at one F_k in
    different ways (while the leg is compressed, and while it extends) it has by the phase, if the
    controller senses F_k alone.
    """
    path = episode.trajectory
    felt, force = jnp.asarray(path.spring_force_n), jnp.asarray(path.actuator_force_n)
    if not episode.has_oscillator:
        return jnp.full(felt.shape[1:], jnp.nan)
    stance = felt > 0.0
    size = episode.mean_where(force**2, stance)
    force = force - episode.mean_where(force, stance)[None]
    largest = jnp.max(jnp.where(episode.is_settled & stance, felt, 0.0), axis=0)
    place = _BINS * felt / jnp.where(largest > 0.0, largest, 1.0)[None]
    number = jnp.clip(jnp.floor(place), 0, _BINS - 1)
    place = place - number - 0.5

    def left(of: jax.Array) -> jax.Array:
        """Variance in one bin beside a line, over all of stance."""
        inside = stance & (number == of)
        share = episode.mean_where(inside.astype(force.dtype), stance)

        def mean(values: jax.Array) -> jax.Array:
            return jnp.nan_to_num(episode.mean_where(values, inside))

        x, y = place - mean(place)[None], force - mean(force)[None]
        spread = mean(x * x)
        slope = jnp.where(spread > 0.0, mean(x * y) / jnp.where(spread > 0.0, spread, 1.0), 0.0)
        return share * mean((y - slope[None] * x) ** 2)

    unexplained = jnp.sum(jax.lax.map(left, jnp.arange(_BINS, dtype=place.dtype)), axis=0)
    whole = episode.mean_where(force**2, stance)
    share = unexplained / jnp.where(whole > _STILL**2 * size, whole, jnp.nan)
    return episode.where_settled(jnp.clip(share, 0.0, 1.0))


METRIC = GaitMetric(
    name="phase_share",
    label="by phase",
    about="share of the force's variance in stance left beside a line in each of 12 bins of F_k",
    more_is_better=None,
    range=(0.0, 1.0),
    channels=("spring_force_n", "actuator_force_n"),
    shown=(REPORT,),
    compute=_compute,
)
