"""The phase-response curve: how a short push shifts the rhythm, for good."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tegotae._support.errors import require_count
from tegotae._support.limits import MOST_M, MOST_POINTS, require_within
from tegotae.analysis.maps import turn
from tegotae.analysis.orbit import Orbit, hops_of, require_enterable, require_hopper
from tegotae.measures.hopping.hopping import LimitCycle
from tegotae.parts.bodies import Hopper
from tegotae.parts.maths import TWO_PI
from tegotae.systems.controller_file import SavedController

_TICK_S = 0.001
"""Control period of controllers in continuous time [s]."""


def measure_phase_response(
    saved: SavedController,
    orbit: Orbit,
    push_ns: np.ndarray,
    *,
    points: int = 60,
    cycles: int = 40,
) -> pd.DataFrame:
    """Start on the limit cycle with the velocity changed by J / m, and wait.

        Δθ(θ) = 2π (t∞ - t∞*) / T   (mod 2π),

    where t∞* and t∞ are the times of an apex many cycles on, with the push and without it, and T
    is the period of the cycle. The rollout without a push starts at the same point, so that all
    else is equal and a push of zero shifts nothing.

    Args:
        saved: the controller, its weights, frequency and body.
        orbit: its limit cycle (`find_orbit`).
        push_ns: impulses J [N s], upward if positive, shape [pushes].
        points: how many points of the cycle, evenly spaced in time.
        cycles: how many periods to wait.

    Returns:
        A row a push and point, push by push: the impulse, where it comes (θ = 2π t / T from the
        apex on), the oscillator's phase there, whether that is in stance, and the shift Δθ in
        [-π, π): positive if the rhythm comes earlier, NaN where the gait does not return to its
        limit cycle.

    Raises:
        TegotaeError: for a body without a mass, impulses that are not finite, or fewer than three
            points or cycles.

    Reference: A. T. Winfree, The Geometry of Biological Time, chapter 4.
    """
    require_enterable(saved, "a phase response")
    body = require_hopper(saved.body, "a push")
    push_ns = np.atleast_1d(np.asarray(push_ns, float))
    check_pushes(push_ns, body, points, cycles)

    start = np.searchsorted(orbit.time_s, np.arange(points) / points * orbit.period_s)
    start = np.minimum(start, len(orbit.time_s) - 1)
    pushes = np.concatenate([[0.0], push_ns])
    push, point = (x.ravel() for x in np.meshgrid(pushes, start, indexing="ij"))
    duration_s = (cycles + 2) * orbit.period_s
    table, _ = hops_of(
        saved,
        saved.system.timing_over(duration_s, tick_s=_TICK_S, frame_s=20 * _TICK_S),
        height_m=orbit.height_m[point],
        velocity_m_per_s=orbit.velocity_m_per_s[point] + push / body.mass_kg,
        phase_rad=orbit.phase_rad[point],
        oscillator_state={name: x[point] for name, x in orbit.oscillator_state.items()},
    )
    rows = np.arange(len(push))
    last = table.n_hops - 1
    k = orbit.hops
    unpushed = np.tile(np.arange(points), len(pushes))
    # In a cycle of k hops, the last hop may be any of them: take the one that looks alike.
    distances = np.array(
        [_distance(table, rows, last, unpushed, last[unpushed] - back, k) for back in range(k)]
    )
    alike = last[unpushed] - distances.argmin(axis=0)
    earlier_s = table.time_s[alike, unpushed] - table.time_s[last, rows]
    shift = turn(TWO_PI * earlier_s / orbit.period_s)
    shift = np.where((distances.min(axis=0) <= 1.0) & (last >= k), shift, np.nan)
    rows = len(push_ns)
    return pd.DataFrame(
        {
            "push_ns": np.repeat(push_ns, points),
            "cycle_phase_rad": np.tile(TWO_PI * orbit.time_s[start] / orbit.period_s, rows),
            "oscillator_phase_rad": np.tile(orbit.phase_rad[start], rows),
            "stance": np.tile(orbit.height_m[start] < body.rest_length_m, rows),
            "shift_rad": shift[points:],
        }
    )


def check_pushes(push_ns: np.ndarray, body: Hopper, points: int, cycles: int) -> None:
    """Raise `TegotaeError` for impulses [N s] beyond sense, or too few or many points or cycles."""
    for push in push_ns:
        require_within("push", push, float(body.mass_kg) * MOST_M)
    require_count("points", points, least=3, most=MOST_POINTS)
    require_count("cycles", cycles, least=3, most=MOST_POINTS)


def _distance(table, lanes, rows, other_lanes, other_rows, k) -> np.ndarray:
    """Return the largest distance of the last k hops from their counterparts, in units of the
    settling tolerance.
    """
    back, near = np.arange(k)[:, None], LimitCycle()
    position = np.maximum(rows - back, 0), lanes
    other_position = np.maximum(other_rows - back, 0), other_lanes
    height = (
        np.abs(table.height_m[position] - table.height_m[other_position]) / near.height_tolerance_m
    )
    phase = (
        np.abs(turn(table.phase_rad[position] - table.phase_rad[other_position]))
        / near.phase_tolerance_rad
    )
    return np.nan_to_num(np.maximum(height, phase), nan=np.inf).max(axis=0)
