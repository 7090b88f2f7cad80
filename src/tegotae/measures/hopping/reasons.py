"""Why a recording has no number: what contradicts itself, what is missing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tegotae.measures.hopping.episode import AT_REST, FAILED, LIMIT_CYCLE
from tegotae.measures.hopping.hopping import Hops
from tegotae.measures.hopping.limit_cycle import LimitCycle
from tegotae.measures.hopping.metric import (
    ClampedMetric,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.simulation.rollout import Trajectory

_HOPS = 0.25  # of the swings; less is what hops of several heights make of a spectrum
_CLIMB = 0.1  # of the climb; less is what samples far apart cost
_BOUNCE = 0.01  # of the rest length a hop, which bounces that are no hops may climb


def contradictions(
    frames: Trajectory, table: Hops, span: tuple[int, int], rest_length_m: float
) -> tuple[str, ...]:
    """A sentence on every two measurements of the same that disagree, as noise makes them do.

    From one apex to another, the height's spectrum shows how often the body swings, which is once
    a hop, or once in a few hops of different heights; and the apexes show how much was climbed in
    flight.

    Args:
        frames: the recording, [frames, 1].
        table: its hops, [hops].
        span: rows of the first and last of them.
        rest_length_m: rest length of the leg l0 [m].
    """
    first, last = (int(table.frame[row]) for row in span)
    hops = span[1] - span[0]
    found = []
    swings = _swings(frames.height_m[first : last + 1, 0])
    times = max(1.0, np.round(hops / swings)) if swings else 1.0
    if abs(hops - times * swings) > max(1.0, _HOPS * times * swings):
        found.append(
            f"hops and spectrum contradict each other: {hops} hops, while the height swings "
            f"{swings:.3g} times"
        )
    apexes = slice(span[0] + 1, span[1] + 1)
    over_ground = table.height_m[apexes] - frames.ground_m[table.frame[apexes], 0]
    by_hops = float(np.sum(over_ground - rest_length_m))
    climbed = float(frames.climb_flight_m[last, 0] - frames.climb_flight_m[first, 0])
    if abs(climbed - by_hops) > _CLIMB * by_hops + _BOUNCE * rest_length_m * hops:
        found.append(
            f"hops and climb contradict each other: {climbed:.3g} m climbed in flight, while the "
            f"apexes of {hops} hops rise {by_hops:.3g} m over the rest length"
        )
    if found:
        found.append(
            "noise, bounces too low to be hops, a wrong rest length or a wrong unit do that: look "
            "at --plot, or set --lowpass"
        )
    return tuple(found)


def _swings(height_m: np.ndarray) -> float:
    """How many periods of its strongest frequency a height holds."""
    still = height_m - height_m.mean()
    power = np.abs(np.fft.rfft(np.hanning(len(still)) * still, 8 * len(still))) ** 2
    return float(np.argmax(power)) / 8.0


_FROM_FORCE = ("impulse_ns", "actuator_force_n")
_FROM_WORK = ("work_absolute_j", "work_positive_j", "work_net_j")
_NOT_RECORDED = ("spring_force_n", "feedback_rad_per_s", "energy_j")
_NOT_GIVEN = {
    "omega": "the prescribed frequency ω is not given",
    "max_force_n": "the largest actuator force α is not given",
}


@dataclass(frozen=True, kw_only=True)
class Known:
    """The known parameters of a recording."""

    regime: int
    """Index into `REGIMES`."""
    hops: Hops
    """Its hops, [hops] each."""
    end_s: float
    """Where its undisturbed part ends [s]."""
    limit_cycle: LimitCycle
    """What counts as settled."""
    has_force: bool
    """Whether the actuator force was recorded."""
    has_work: bool
    """Whether its work was recorded, or follows from the force."""
    given: Mapping[str, bool]
    """Whether ω and α were given."""
    disturbed: bool
    """Whether there was a disturbance."""
    has_body: bool
    """Whether the body was given."""


def why_undefined(metric: Metric, values: Mapping[str, float], known: Known) -> str:
    """Why a metric that is NaN in `values` is undefined."""
    if isinstance(metric, ClampedMetric):
        return "it takes simulations with the oscillator held still, which no recording is"
    if isinstance(metric, DerivedMetric):
        return _of_derived(metric, values, known)
    assert isinstance(metric, GaitMetric)
    if metric.disturbed and not known.disturbed:
        return "there was no disturbance"
    if known.regime != LIMIT_CYCLE:
        return no_cycle(known)
    return _not_recorded(metric, known) or (
        "the gait does not settle again before the recording ends"
        if metric.disturbed
        else "the work is negative in sum"
        if set(metric.channels) & set(_FROM_WORK)
        else "it has no value for this gait"
    )


def _not_recorded(metric: GaitMetric, known: Known) -> str:
    reads = set(metric.channels)
    if reads & set(_FROM_WORK) and not known.has_work:
        return "neither the actuator force nor its work was recorded"
    if reads & set(_FROM_FORCE) and not known.has_force:
        return "the actuator force was not recorded"
    for channel in _NOT_RECORDED:
        if channel in reads:
            return f"a recording has no {channel}"
    return next((words for name, words in _NOT_GIVEN.items() if name in metric.parameters
                 and not known.given[name]), "")  # fmt: skip


def _of_derived(metric: DerivedMetric, values: Mapping[str, float], known: Known) -> str:
    for name in metric.of:
        if np.isnan(values.get(name, 0.0)):
            return f"{name} is undefined"
    if metric.needs_body and not known.has_body:
        return "it takes the body, which is not given"
    return "it has no value for such a gait of this body"


def no_cycle(known: Known) -> str:
    """Why there is no limit cycle: how far the last hops are from repeating themselves."""
    table, count = known.hops, int(np.sum(known.hops.time_s <= known.end_s))
    if known.regime == FAILED:
        return "the body failed"
    needed = known.limit_cycle.min_repeats + 1
    if known.regime == AT_REST:
        return "no hop" if count == 0 else f"no hop after {table.time_s[count - 1]:.1f} s"
    if count < needed:
        return f"{count} hops; a limit cycle has to show at least {needed}"
    height, phase, period = min(
        (_spread(known, count, period) for period in range(1, known.limit_cycle.max_period + 1)
         if count >= needed * period),
        key=lambda spread: max(_over(known.limit_cycle, *spread[:2])),
    )  # fmt: skip
    over_height, over_phase = _over(known.limit_cycle, height, phase)
    if max(over_height, over_phase) <= 1.0:
        return f"the hops stop at {table.time_s[count - 1]:.1f} s, before the recording ends"
    far = []
    if over_height > 1.0:
        allowed = known.limit_cycle.height_tolerance_m
        far.append(f"{1e3 * height:.3g} mm in height ({1e3 * allowed:g} are allowed)")
    if over_phase > 1.0:
        allowed = known.limit_cycle.phase_tolerance_rad
        far.append(f"{phase:.2g} rad in phase ({allowed:g} are allowed)")
    every = "each other" if period == 1 else f"every {period} hops"
    return f"the last {needed * period} hops differ from {every} by {' and '.join(far)}"


def _spread(known: Known, count: int, period: int) -> tuple[float, float, int]:
    """How far the last hops are from the last cycle of a period, in height [m] and phase [rad]."""
    rows = np.arange(count - (known.limit_cycle.min_repeats + 1) * period, count)
    last = count - 1 - (count - 1 - rows) % period
    height = np.abs(known.hops.height_m[rows] - known.hops.height_m[last])
    phase = known.hops.phase_rad[rows] - known.hops.phase_rad[last]
    turned = np.abs((phase + math.pi) % (2.0 * math.pi) - math.pi)
    return float(height.max()), float(turned.max()), period


def _over(tolerance: LimitCycle, height_m: float, phase_rad: float) -> tuple[float, float]:
    """Both over what is allowed."""
    return (
        height_m / tolerance.height_tolerance_m,
        phase_rad / tolerance.phase_tolerance_rad,
    )
