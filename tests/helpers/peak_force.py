"""A user's own metric, in a file of its own as a user would write it."""

import jax.numpy as jnp

from tegotae.measures.hopping import Conditions, DerivedMetric, Episode, GaitMetric


def _peak_force(episode: Episode) -> jnp.ndarray:
    force = episode.trajectory.actuator_force_n
    settled = episode.trajectory.time_s >= episode.start_s[None]
    return episode.where_settled(jnp.max(jnp.where(settled, force, 0.0), axis=0))


peak_force = GaitMetric(
    name="peak_force_n",
    label="peak force",
    math=r"$F_\mathrm{a,max}$",
    unit="N",
    about="largest actuator force of the settled part",
    more_is_better=False,
    range=(0.0, float("inf")),
    channels=("actuator_force_n",),
    compute=_peak_force,
)


def _in_weights(values: dict, conditions: Conditions) -> jnp.ndarray:
    return values["peak_force_n"] / conditions.body.weight_n


peak_force_in_weights = DerivedMetric(
    name="peak_force_in_weights",
    label="peak force / weight",
    about="the same in weights of the body",
    more_is_better=None,
    range=(0.0, float("inf")),
    of=("peak_force_n",),
    compute=_in_weights,
    needs_body=True,
)
