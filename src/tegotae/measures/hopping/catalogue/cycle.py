"""How soon and how often a gait settles on a limit cycle, and which one."""

from __future__ import annotations

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.metric import (
    FAILED,
    LIMIT_CYCLE,
    REGIME,
    REPORT,
    TABLE,
    Conditions,
    DerivedMetric,
    Episode,
    GaitMetric,
)
from tegotae.measures.hopping.statistics import POSITIVE, SHARE

# Source: paper IV-A, T0.
T0 = GaitMetric(
    name="t0_s",
    label="T0",
    unit="s",
    about="time from release until settled",
    more_is_better=False,
    range=POSITIVE,
    compute=lambda episode: episode.where_settled(episode.cycle.time_s),
)


def _t1(episode: Episode) -> jax.Array:
    if episode.disturbed_at_s is None:
        return jnp.full_like(episode.cycle.time_s, jnp.nan)
    touchdowns = jnp.asarray(episode.whole.touchdown_time_s)
    after = touchdowns > jnp.asarray(episode.disturbed_at_s, touchdowns.dtype).reshape(1, -1)
    touchdown = jnp.min(jnp.where(after, touchdowns, jnp.inf), axis=0)
    again = episode.settles_again(touchdown)
    fell = episode.whole.failed[-1]
    return episode.where_settled(jnp.where(fell, jnp.nan, again.time_s - touchdown))


# Source: paper IV-A, T1.
T1 = GaitMetric(
    name="t1_s",
    label="T1",
    unit="s",
    about="time from the first touchdown after a drop of the ground until settled again",
    more_is_better=False,
    range=POSITIVE,
    disturbed=True,
    compute=_t1,
)


# Source: of this library; the paper (IV-A) asks for a limit cycle of any period.
LIMIT_CYCLE_PERIOD = GaitMetric(
    name="limit_cycle_period",
    label="period",
    unit="hops",
    about="hops after which the limit cycle repeats itself",
    more_is_better=None,
    range=(1.0, float("inf")),
    shown=(),
    compute=lambda episode: episode.where_settled(episode.cycle.period),
)


# Source: of this library; the paper (IV-A) asks of every episode whether a limit cycle forms.
LIMIT_CYCLE_SHARE = DerivedMetric(
    name="limit_cycle_share",
    label="limit cycles",
    about="share of the episodes with a limit cycle",
    more_is_better=True,
    range=SHARE,
    of=(REGIME,),
    compute=lambda values, conditions: (values[REGIME] == LIMIT_CYCLE).astype(float),
)


def _recovery_share(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    tested = (values["limit_cycle_share"] == 1.0) & (conditions.drop_m > 0.0)
    return np.where(tested, np.isfinite(values["t1_s"]), np.nan)


# Source: paper IV-A, on T1: "new limit cycle formation, if any".
RECOVERY_SHARE = DerivedMetric(
    name="recovery_share",
    label="recovers",
    about="share of the settled episodes that settle again after a drop of the ground",
    more_is_better=True,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "t1_s"),
    compute=_recovery_share,
)


# Source: of this library.
FAILED_SHARE = DerivedMetric(
    name="failed_share",
    label="failed",
    about="share of the episodes in which the body fails before it is disturbed",
    more_is_better=False,
    range=SHARE,
    shown=(),
    of=(REGIME,),
    compute=lambda values, conditions: (values[REGIME] == FAILED).astype(float),
)


def _at_rest_share(values: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
    # Of what does not settle, a body at rest alone has a CoT⁻¹.
    rests = (values["limit_cycle_share"] == 0.0) & (values["cot_inverse"] == 0.0)
    return rests.astype(float)


# Source: of this library; such an episode has no limit cycle, and a CoT⁻¹ of zero.
AT_REST_SHARE = DerivedMetric(
    name="at_rest_share",
    label="at rest",
    about="share of the episodes in which the body no longer hops before it is disturbed",
    more_is_better=False,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "cot_inverse"),
    compute=_at_rest_share,
)


def _hop_rate(episode: Episode) -> jax.Array:
    cycle = episode.cycle
    cycles_s = episode.apex_s(cycle.to_hop) - episode.apex_s(cycle.from_hop)
    hops_s = cycles_s / (cycle.to_hop - cycle.from_hop).astype(cycles_s.dtype)
    return episode.where_settled(2.0 * jnp.pi / hops_s)


# Source: of this library.
HOP_RATE = GaitMetric(
    name="hop_rate",
    label="hop rate",
    unit="rad/s",
    about="2π times hops over time, over the cycles of CoT⁻¹",
    more_is_better=None,
    range=POSITIVE,
    shown=(TABLE, REPORT),
    compute=_hop_rate,
)
