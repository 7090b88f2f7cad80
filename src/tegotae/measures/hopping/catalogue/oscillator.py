"""How much a gait depends on its oscillator and its feedback."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.metric import REPORT, ClampedMetric, Episode, GaitMetric
from tegotae.measures.hopping.statistics import SHARE

# Source: paper IV-A.
CPGU = ClampedMetric(
    name="cpgu",
    label="CPGu",
    about="share of clamped phases without a limit cycle: 1 depends fully on the oscillator",
    more_is_better=None,
    range=SHARE,
    compute=lambda clamped: 1.0 - clamped.on_cycle.mean(axis=-1),
)


def _feedback_share(episode: Episode) -> jax.Array:
    """Mean |f| over ω + mean |f|, over the settled part: 0 if the feedback is off."""
    feedback = jnp.abs(jnp.asarray(episode.trajectory.feedback_rad_per_s))
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    mean = episode.mean_where(feedback, True)
    return episode.where_settled(mean / (jnp.asarray(episode.omega) + mean))


# Source: of this library, for the paper's "switches off the oscillator feedback mechanism" (V).
FEEDBACK_SHARE = GaitMetric(
    name="feedback_share",
    label="by feedback",
    about="size of the feedback, mean |f| over ω + mean |f|",
    more_is_better=None,
    range=SHARE,
    channels=("feedback_rad_per_s",),
    parameters=("omega",),
    shown=(REPORT,),
    compute=_feedback_share,
)


def _feedback_while_pushing(episode: Episode) -> jax.Array:
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    pushes = jnp.asarray(episode.trajectory.actuator_force_n) > 0.0
    return episode.where_settled(episode.mean_where(feedback, pushes))


# Source: of this library, for the paper's "the oscillator is slowed down during actuation" (V).
FEEDBACK_WHILE_PUSHING = GaitMetric(
    name="feedback_while_pushing",
    label="f pushing",
    unit="rad/s",
    about="mean feedback while the actuator pushes; below zero it slows the oscillator",
    more_is_better=None,
    channels=("feedback_rad_per_s", "actuator_force_n"),
    shown=(),
    compute=_feedback_while_pushing,
)


_BINS = 12
"""Of the spring force, from zero to its largest; in each of them the force may follow a line."""


_STILL = 1e-3
"""A force that varies less than this, over its own size, has no variance to be explained."""


def _phase_share(episode: Episode) -> jax.Array:
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


# Source: of this library, for the paper's "independence of the actuation instant from the
# oscillator state, while the actuation force is solely modulated by F_k" (V).
PHASE_SHARE = GaitMetric(
    name="phase_share",
    label="by phase",
    about="share of the force's variance in stance left beside a line in each of 12 bins of F_k",
    more_is_better=None,
    range=SHARE,
    channels=("spring_force_n", "actuator_force_n"),
    shown=(REPORT,),
    compute=_phase_share,
)
