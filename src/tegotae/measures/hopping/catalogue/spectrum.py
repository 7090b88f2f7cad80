"""The spectrum of the body's height beside the prescribed frequency."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.metric import REPORT, TABLE, Episode, GaitMetric
from tegotae.measures.hopping.signals import delta_omega, delta_w
from tegotae.measures.hopping.statistics import POSITIVE, SHARE

# Source: paper equation 13, w_peak.
W_PEAK = GaitMetric(
    name="w_peak",
    label="w peak",
    math=r"$w_\mathrm{peak}$",
    unit="rad/s",
    about="frequency of the highest peak of the height's spectrum, over the settled part",
    more_is_better=None,
    range=POSITIVE,
    channels=("height_m",),
    shown=(),
    compute=lambda episode: episode.where_settled(episode.peak[0]),
)


# Source: paper equation 13, A_peak.
A_PEAK = GaitMetric(
    name="a_peak",
    label="A peak",
    math=r"$A_\mathrm{peak}$",
    about="square root of the power's share in the spectrum's highest peak",
    more_is_better=None,
    range=SHARE,
    channels=("height_m",),
    shown=(),
    compute=lambda episode: episode.where_settled(episode.peak[1]),
)


def _delta_omega(episode: Episode) -> jax.Array:
    if not episode.has_oscillator:  # no prescribed frequency to deviate from, as in the fitness
        return episode.where_settled(jnp.zeros_like(episode.cycle.time_s))
    return episode.where_settled(delta_omega(episode.omega, *episode.peak))


# Source: paper equation 13.
DELTA_OMEGA = GaitMetric(
    name="delta_omega",
    label="ΔΩ",
    unit="rad²/s²",
    about="deviation from a pure oscillation at ω (equation 13)",
    more_is_better=True,
    range=(-float("inf"), 0.0),
    channels=("height_m",),
    parameters=("omega",),
    shown=(TABLE, REPORT),
    compute=_delta_omega,
)


# Source: paper equation 14.
DELTA_W = GaitMetric(
    name="delta_w",
    label="Δw",
    unit="rad/s",
    about="distance of the spectrum's peaks from ω (equation 14)",
    more_is_better=False,
    range=POSITIVE,
    channels=("height_m",),
    parameters=("omega",),
    compute=lambda episode: episode.where_settled(delta_w(episode.spectrum, episode.omega)),
)
