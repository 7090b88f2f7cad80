"""The limit cycle that a controller settles on, as one turn of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import numpy as np

from tegotae.analysis.outcome import OutcomeSummary
from tegotae.controller_file import SavedController
from tegotae.errors import TegotaeError, require_finite
from tegotae.metrics.gait import LIMIT_CYCLE, REGIMES
from tegotae.metrics.hopping import hops
from tegotae.rollout import Engine, Scenario, Timing, Trajectory

SETTLE_S = 60.0
"""Simulated time in which a gait has to settle [s]."""


class NoLimitCycleError(TegotaeError):
    """The controller does not settle on a limit cycle."""


@dataclass(frozen=True)
class Orbit:
    """One turn of a limit cycle: k hops, from an apex to the k-th apex after it.

    Samples are a control tick apart; the first lies at most a tick after the first apex.
    """

    hops: int
    """Period k [hops]."""
    period_s: float
    """Period T [s]."""
    apex_height_m: np.ndarray
    """Heights of its apexes [m], shape [k]."""
    apex_phase_rad: np.ndarray
    """Phases at its apexes [rad], shape [k]; zero without an oscillator."""
    time_s: np.ndarray
    """Time since the first apex [s], shape [samples]."""
    height_m: np.ndarray
    """Height y [m], [samples]."""
    velocity_m_per_s: np.ndarray
    """Velocity ẏ [m/s], [samples]."""
    phase_rad: np.ndarray
    """Phase φ modulo 2π [rad], [samples]; zero without an oscillator."""
    spring_force_n: np.ndarray
    """Spring force F_k [N], [samples]."""
    feedback_rad_per_s: np.ndarray
    """Tegotae feedback f [rad/s], [samples]."""
    actuator_force_n: np.ndarray
    """Actuator force F_a [N], [samples]; zero in flight."""


def find_orbit(
    saved: SavedController,
    *,
    height_m: float = 1.2,
    phase_rad: float = 0.0,
    settle_s: float = SETTLE_S,
    tick_s: float = 0.001,
) -> Orbit:
    """Release a controller's body, let it settle, and return its last limit cycle.

    Args:
        saved: the controller, its weights, frequency and body.
        height_m: release height, at rest [m].
        phase_rad: phase at release [rad].
        settle_s: simulated time in which to settle [s].
        tick_s: control period, and the time between samples [s].

    Raises:
        NoLimitCycleError: if it does not settle; says what it does instead.
        TegotaeError: for a release that is not finite.

    Example:
        >>> from tegotae import build
        >>> saved = SavedController(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> found = find_orbit(saved)
        >>> found.hops, round(found.period_s, 3)
        (1, 0.868)
    """
    require_finite("height", height_m)
    require_finite("phase", phase_rad)
    timing = Timing(duration_s=settle_s, tick_s=tick_s, frame_s=tick_s)
    engine = Engine(controller=saved.controller, timing=timing)
    scenario = Scenario(omega=saved.omega, height_m=height_m, phase_rad=phase_rad)
    lanes = engine.run(saved.weights, scenario, saved.body, dtype="float64")
    with jax.enable_x64(True):
        outcome = OutcomeSummary()(lanes, scenario, saved.body, timing)
        table = hops(lanes, saved.body.rest_length_m)
        regime = int(np.asarray(outcome.regime)[0])
        times, heights, phases, frames = (
            np.asarray(x)[: int(np.asarray(table.count)[0]), 0]
            for x in (table.time_s, table.height_m, table.phase_rad, table.frame)
        )
    if regime != LIMIT_CYCLE:
        raise NoLimitCycleError(
            f"released from {height_m:g} m at phase {phase_rad:g} rad, the gait has no limit cycle "
            f"after {settle_s:g} s: {REGIMES[regime]}"
        )
    k = int(np.asarray(outcome.limit_cycle_period)[0])
    path = Trajectory(*(np.asarray(x)[frames[-k - 1] : frames[-1], 0] for x in lanes))
    return Orbit(
        hops=k,
        period_s=float(times[-1] - times[-k - 1]),
        apex_height_m=heights[-k - 1 : -1],
        apex_phase_rad=phases[-k - 1 : -1],
        time_s=path.time_s - times[-k - 1],
        height_m=path.height_m,
        velocity_m_per_s=path.velocity_m_per_s,
        phase_rad=path.phase_rad % (2.0 * math.pi),
        spring_force_n=path.spring_force_n,
        feedback_rad_per_s=path.feedback_rad_per_s,
        actuator_force_n=path.actuator_force_n,
    )
