"""A user's file with metrics: of the ground reaction force, as anyone would write it."""

from __future__ import annotations

import jax.numpy as jnp

from tegotae.measures.hopping import DerivedMetric, GaitMetric

peak_grf = GaitMetric(
    name="peak_grf_n",
    label="peak GRF",
    unit="N",
    about="largest force of the leg on the ground in an episode",
    more_is_better=False,
    range=(0.0, float("inf")),
    channels=("spring_force_n",),
    compute=lambda episode: jnp.max(episode.trajectory.spring_force_n, axis=0),
)

peak_grf_in_weights = DerivedMetric(
    name="peak_grf_in_weights",
    label="peak GRF / weight",
    about="the same in weights of the body",
    more_is_better=False,
    range=(0.0, float("inf")),
    of=("peak_grf_n",),
    compute=lambda values, conditions: values["peak_grf_n"] / conditions.body.weight_n,
    needs_body=True,
)
