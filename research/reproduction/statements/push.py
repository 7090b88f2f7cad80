"""Metrics of a push, registered while the statements are measured."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.metrics import HOPPING, Episode, GaitMetric
from tegotae.measures.statistics import POSITIVE, SHARE
from tegotae.systems.registry import register

_LOW, _HIGH = 0.05, 0.95
"""Between these shares of its largest value a force is neither off nor full."""


def _force(episode: Episode) -> jax.Array:
    return jnp.asarray(episode.trajectory.actuator_force_n)


@GaitMetric.described(
    label="push",
    more_is_better=None,
    range=SHARE,
    channels=("spring_force_n", "actuator_force_n"),
    shown=(),
)
def push_share(episode: Episode) -> jax.Array:
    """share of the stance in which the actuator pushes"""
    stance = jnp.asarray(episode.trajectory.spring_force_n) > 0.0
    pushes = (_force(episode) > 0.0).astype(jnp.float32)
    return episode.where_settled(episode.mean_where(pushes, stance))


@GaitMetric.described(
    label="graded push",
    more_is_better=None,
    range=SHARE,
    channels=("actuator_force_n",),
    shown=(),
)
def graded_share(episode: Episode) -> jax.Array:
    """share of the push in which the force is neither off nor full"""
    force = _force(episode)
    largest = jnp.max(jnp.where(episode.is_settled, force, 0.0), axis=0)
    graded = (force > _LOW * largest) & (force < _HIGH * largest)
    return episode.where_settled(episode.mean_where(graded.astype(force.dtype), force > 0.0))


@GaitMetric.described(
    label="df/dt",
    unit="1/s",
    more_is_better=None,
    range=POSITIVE,
    channels=("feedback_rad_per_s",),
    shown=(),
)
def feedback_change(episode: Episode) -> jax.Array:
    """mean rate of change of the feedback over its mean size"""
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    steps = jnp.abs(jnp.diff(feedback, axis=0, prepend=feedback[:1])) / episode.frame_s
    size = episode.mean_where(jnp.abs(feedback), True)
    return episode.where_settled(
        jnp.where(size > 0.0, episode.mean_where(steps, True) / size, jnp.nan)
    )


def _onset(episode: Episode, part: str) -> jax.Array:
    """Return the mean cosine or sine of the phase at which pushes begin, [lanes]."""
    pushes = _force(episode) > 0.0
    begins = pushes & ~jnp.concatenate([pushes[:1], pushes[:-1]])
    phase = jnp.asarray(episode.trajectory.phase_rad)
    values = jnp.cos(phase) if part == "cos" else jnp.sin(phase)
    return episode.where_settled(episode.mean_where(values, begins))


_OF_ONSET = ("phase_rad", "actuator_force_n")


@GaitMetric.described(label="cos onset", more_is_better=None, channels=_OF_ONSET, shown=())
def onset_cos(episode: Episode) -> jax.Array:
    """mean cosine of the phase at which pushes begin"""
    return _onset(episode, "cos")


@GaitMetric.described(label="sin onset", more_is_better=None, channels=_OF_ONSET, shown=())
def onset_sin(episode: Episode) -> jax.Array:
    """mean sine of the phase at which pushes begin"""
    return _onset(episode, "sin")


PUSH = (push_share, graded_share, feedback_change, onset_cos, onset_sin)
"""The metrics of a push."""


@contextmanager
def push_metrics() -> Iterator[None]:
    """Register the metrics of a push, and remove them in the end."""
    for metric in PUSH:
        register(metric)
    try:
        yield
    finally:
        for metric in PUSH:
            HOPPING.forget(metric.name)
