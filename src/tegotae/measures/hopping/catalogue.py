"""The package's metrics, in the order in which tables show them: that of this file."""

from __future__ import annotations

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping import signals
from tegotae.measures.hopping.metric import (
    AT_REST,
    FAILED,
    LIMIT_CYCLE,
    REGIME,
    REPORT,
    TABLE,
    ClampedEpisodes,
    ClampedMetric,
    Conditions,
    DerivedMetric,
    Episode,
    GaitMetric,
    Metric,
)
from tegotae.measures.hopping.statistics import POSITIVE, SHARE
from tegotae.measures.optimum import has_table, share
from tegotae.parts._shapes import AnyArray

Values = Mapping[str, np.ndarray]
"""Values of other metrics by name, of one shape."""

WORK = ("work_absolute_j", "work_positive_j", "work_net_j")
"""The channels of the actuator's work, by every definition."""


def over_cycles(episode: Episode, climbed_m: AnyArray) -> jax.Array:
    """CoT⁻¹ of a running total of climbed heights [m], [frames, lanes], over whole cycles [m/J].

    Zero for a body at rest or one that does no work, and undefined without a limit cycle.
    """
    work = episode.work_j
    efficiency = signals.cot_inverse(episode.over_cycles(climbed_m), work)
    # Negative work (and work that was not recorded) has no efficiency.
    value = jnp.where(work > -1e-6, efficiency, jnp.nan)
    return jnp.where(episode.regime == AT_REST, 0.0, episode.where_settled(value))


# Source: paper equation 12, the variant A of Fig. 4.
@GaitMetric.described(
    label="CoT⁻¹",
    unit="m/J",
    more_is_better=True,
    range=POSITIVE,
    channels=(*WORK, "climb_flight_m"),
)
def cot_inverse(episode: Episode) -> jax.Array:
    """height climbed in flight per work, over the settled part (equation 12)"""
    return over_cycles(episode, episode.whole.climb_flight_m)


# Source: of this library (`tegotae.measures.optimum`).
@DerivedMetric.described(
    label="of optimum",
    more_is_better=True,
    range=POSITIVE,
    of=("cot_inverse", "hop_rate", "limit_cycle_period"),
    needs_body=True,
)
def optimum_share(values: Values, conditions: Conditions) -> np.ndarray:
    """CoT⁻¹ over the largest that any force can have at the gait's own hop rate"""
    cot, rate = values["cot_inverse"], values["hop_rate"]
    if not has_table(conditions.body, conditions.work):
        return np.full(np.shape(cot), np.nan)
    return share(cot, rate, values["limit_cycle_period"])


# Source: paper equation 12, the variant B of Fig. 4.
@GaitMetric.described(
    label="CoT⁻¹ B",
    unit="m/J",
    more_is_better=True,
    range=POSITIVE,
    channels=(*WORK, "climb_m"),
    shown=(TABLE, REPORT),
)
def cot_inverse_total(episode: Episode) -> jax.Array:
    """height climbed in flight and in stance per work, over the settled part"""
    return over_cycles(episode, episode.whole.climb_m)


# Source: paper IV-A, T0.
@GaitMetric.described(label="T0", unit="s", more_is_better=False, range=POSITIVE)
def t0_s(episode: Episode) -> jax.Array:
    """time from release until settled"""
    return episode.where_settled(episode.cycle.time_s)


# Source: paper IV-A, T1.
@GaitMetric.described(label="T1", unit="s", more_is_better=False, range=POSITIVE, disturbed=True)
def t1_s(episode: Episode) -> jax.Array:
    """time from the first touchdown after a drop of the ground until settled again"""
    if episode.disturbed_at_s is None:
        return jnp.full_like(episode.cycle.time_s, jnp.nan)
    touchdowns = jnp.asarray(episode.whole.touchdown_time_s)
    later = touchdowns > jnp.asarray(episode.disturbed_at_s, touchdowns.dtype).reshape(1, -1)
    touchdown = jnp.min(jnp.where(later, touchdowns, jnp.inf), axis=0)
    again = episode.settles_again(touchdown)
    fell = episode.whole.failed[-1]
    return episode.where_settled(jnp.where(fell, jnp.nan, again.time_s - touchdown))


# Source: paper equation 13.
@GaitMetric.described(
    label="ΔΩ",
    unit="rad²/s²",
    more_is_better=True,
    range=(-float("inf"), 0.0),
    channels=("height_m",),
    parameters=("omega",),
    shown=(TABLE, REPORT),
)
def delta_omega(episode: Episode) -> jax.Array:
    """deviation from a pure oscillation at ω (equation 13)"""
    if not episode.has_oscillator:  # no prescribed frequency to deviate from, as in the fitness
        return episode.where_settled(jnp.zeros_like(episode.cycle.time_s))
    return episode.where_settled(signals.delta_omega(episode.omega, *episode.peak))


# Source: paper equation 14.
@GaitMetric.described(
    label="Δw",
    unit="rad/s",
    more_is_better=False,
    range=POSITIVE,
    channels=("height_m",),
    parameters=("omega",),
)
def delta_w(episode: Episode) -> jax.Array:
    """distance of the spectrum's peaks from ω (equation 14)"""
    return episode.where_settled(signals.delta_w(episode.spectrum, episode.omega))


# Source: paper IV-A.
@ClampedMetric.described(label="CPGu", more_is_better=None, range=SHARE)
def cpgu(clamped: ClampedEpisodes) -> np.ndarray:
    """share of clamped phases without a limit cycle: 1 depends fully on the oscillator"""
    return 1.0 - clamped.on_cycle.mean(axis=-1)


# Source: of this library; the paper (IV-A) asks for a limit cycle of any period.
@GaitMetric.described(
    label="period", unit="hops", more_is_better=None, range=(1.0, float("inf")), shown=()
)
def limit_cycle_period(episode: Episode) -> jax.Array:
    """hops after which the limit cycle repeats itself"""
    return episode.where_settled(episode.cycle.period)


# Source: of this library; the paper (IV-A) asks of every episode whether a limit cycle forms.
@DerivedMetric.described(label="limit cycles", more_is_better=True, range=SHARE, of=(REGIME,))
def limit_cycle_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes with a limit cycle"""
    return (values[REGIME] == LIMIT_CYCLE).astype(float)


# Source: paper IV-A, on T1: "new limit cycle formation, if any".
@DerivedMetric.described(
    label="recovers",
    more_is_better=True,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "t1_s"),
)
def recovery_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the settled episodes that settle again after a drop of the ground"""
    tested = (values["limit_cycle_share"] == 1.0) & (conditions.drop_m > 0.0)
    return np.where(tested, np.isfinite(values["t1_s"]), np.nan)


# Source: of this library.
@DerivedMetric.described(label="failed", more_is_better=False, range=SHARE, shown=(), of=(REGIME,))
def failed_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes in which the body fails before it is disturbed"""
    return (values[REGIME] == FAILED).astype(float)


# Source: of this library; such an episode has no limit cycle, and a CoT⁻¹ of zero.
@DerivedMetric.described(
    label="at rest",
    more_is_better=False,
    range=SHARE,
    shown=(),
    of=("limit_cycle_share", "cot_inverse"),
)
def at_rest_share(values: Values, conditions: Conditions) -> np.ndarray:
    """share of the episodes in which the body no longer hops before it is disturbed"""
    # Of what does not settle, a body at rest alone has a CoT⁻¹.
    rests = (values["limit_cycle_share"] == 0.0) & (values["cot_inverse"] == 0.0)
    return rests.astype(float)


# Source: of this library; the paper (V) calls actuation smooth and gives no measure.
@GaitMetric.described(
    label="dF/dt",
    unit="1/s",
    more_is_better=False,
    range=POSITIVE,
    channels=("impulse_ns",),
    parameters=("max_force_n",),
    shown=(TABLE, REPORT),
)
def smoothness(episode: Episode) -> jax.Array:
    """root-mean-square rate of change of the actuator force over its largest value"""
    impulse_ns = episode.trajectory.impulse_ns
    value = signals.smoothness(impulse_ns, episode.max_force_n, episode.frame_s, episode.start_s)
    return episode.where_settled(value)


# Source: paper equation 13, w_peak.
@GaitMetric.described(
    label="w peak",
    math=r"$w_\mathrm{peak}$",
    unit="rad/s",
    more_is_better=None,
    range=POSITIVE,
    channels=("height_m",),
    shown=(),
)
def w_peak(episode: Episode) -> jax.Array:
    """frequency of the highest peak of the height's spectrum, over the settled part"""
    return episode.where_settled(episode.peak[0])


# Source: paper equation 13, A_peak.
@GaitMetric.described(
    label="A peak",
    math=r"$A_\mathrm{peak}$",
    more_is_better=None,
    range=SHARE,
    channels=("height_m",),
    shown=(),
)
def a_peak(episode: Episode) -> jax.Array:
    """square root of the power's share in the spectrum's highest peak"""
    return episode.where_settled(episode.peak[1])


# Source: of this library.
@GaitMetric.described(
    label="hop rate", unit="rad/s", more_is_better=None, range=POSITIVE, shown=(TABLE, REPORT)
)
def hop_rate(episode: Episode) -> jax.Array:
    """2π times hops over time, over the cycles of CoT⁻¹"""
    cycle = episode.cycle
    cycles_s = episode.apex_s(cycle.to_hop) - episode.apex_s(cycle.from_hop)
    hops_s = cycles_s / (cycle.to_hop - cycle.from_hop).astype(cycles_s.dtype)
    return episode.where_settled(2.0 * jnp.pi / hops_s)


# Source: of this library, for the paper's "switches off the oscillator feedback mechanism" (V).
@GaitMetric.described(
    label="by feedback",
    more_is_better=None,
    range=SHARE,
    channels=("feedback_rad_per_s",),
    parameters=("omega",),
    shown=(REPORT,),
)
def feedback_share(episode: Episode) -> jax.Array:
    """size of the feedback, mean |f| over ω + mean |f|

    Over the settled part: 0 if the feedback is off.
    """
    feedback = jnp.abs(jnp.asarray(episode.trajectory.feedback_rad_per_s))
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    mean = episode.mean_where(feedback, True)
    return episode.where_settled(mean / (jnp.asarray(episode.omega) + mean))


_BINS = 12
"""Number of bins of the spring force, from zero to its largest value; the force may follow a line
in each."""

_STILL = 1e-3
"""A force that varies less than this, over its own size, has no variance to be explained."""


# Source: of this library, for the paper's "independence of the actuation instant from the
# oscillator state, while the actuation force is solely modulated by F_k" (V).
@GaitMetric.described(
    label="by phase",
    more_is_better=None,
    range=SHARE,
    channels=("spring_force_n", "actuator_force_n"),
    shown=(REPORT,),
)
def phase_share(episode: Episode) -> jax.Array:
    """share of the force's variance in stance left beside a line in each of 12 bins of F_k

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

    def residual(bin_number: jax.Array) -> jax.Array:
        """Variance in one bin beside a line, over all of stance."""
        inside = stance & (number == bin_number)
        share = episode.mean_where(inside.astype(force.dtype), stance)

        def mean(values: jax.Array) -> jax.Array:
            return jnp.nan_to_num(episode.mean_where(values, inside))

        x, y = place - mean(place)[None], force - mean(force)[None]
        spread = mean(x * x)
        slope = jnp.where(spread > 0.0, mean(x * y) / jnp.where(spread > 0.0, spread, 1.0), 0.0)
        return share * mean((y - slope[None] * x) ** 2)

    unexplained = jnp.sum(jax.lax.map(residual, jnp.arange(_BINS, dtype=place.dtype)), axis=0)
    variance = episode.mean_where(force**2, stance)
    share = unexplained / jnp.where(variance > _STILL**2 * size, variance, jnp.nan)
    return episode.where_settled(jnp.clip(share, 0.0, 1.0))


# Source: of this library, for the paper's "the oscillator is slowed down during actuation" (V).
@GaitMetric.described(
    label="f pushing",
    unit="rad/s",
    more_is_better=None,
    channels=("feedback_rad_per_s", "actuator_force_n"),
    shown=(),
)
def feedback_while_pushing(episode: Episode) -> jax.Array:
    """mean feedback while the actuator pushes; below zero it slows the oscillator"""
    feedback = jnp.asarray(episode.trajectory.feedback_rad_per_s)
    if not episode.has_oscillator:
        return jnp.full(feedback.shape[1:], jnp.nan)
    pushes = jnp.asarray(episode.trajectory.actuator_force_n) > 0.0
    return episode.where_settled(episode.mean_where(feedback, pushes))


METRICS = tuple(metric for metric in tuple(globals().values()) if isinstance(metric, Metric))
"""All of the above, in this order."""
