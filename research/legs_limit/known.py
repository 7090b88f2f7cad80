"""Read the limits of a walk's cost: a proved bound for walkers, and the best gaits found for
quadruped C.

The bound is on this page of code; what was found, by `research/legs_limit/run.py`, is a kept
table. The argument and the results are in docs/studies/legs_limit.md.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tegotae._support.errors import require_finite, require_known
from tegotae.parts.bodies import Walker

KEPT = Path(__file__).resolve().parents[2] / "research" / "legs_limit" / "known.csv"
FEET = ("free", "ellipse")
"""Kinds of motion of the feet in the kept limits."""


def stance_loss_j(
    impulse_ns: ArrayLike, stance_s: ArrayLike, stiffness_n_per_m: float, damping_ns_per_m: float
) -> np.ndarray:
    """Return the least energy that a leg loses while it bears an impulse within a time [J].

    A leg is a spring K beside a damper D, whose length can be commanded at will. It bears
    N = max(0, K d + D ḋ) while d ≥ 0, from d = 0 on. Whatever d(t), to bear J = ∫ N dt within τ
    loses at least

        12 D J² / (K² [(τ + 2ρ)³ - (2ρ)³]),    ρ = D / K,

    in the damper and in the spring that is let go. d = b t (τ + 2ρ - t) loses just that.

    Args:
        impulse_ns: J [N s].
        stance_s: τ [s].
        stiffness_n_per_m: K [N/m].
        damping_ns_per_m: D [N s/m].

    Returns:
        The loss, of the common shape of J and τ.

    Raises:
        TegotaeError: for a stiffness that is not positive or a damping below zero.

    Source: docs/studies/legs_limit.md.

    Example:
        >>> print(f"{stance_loss_j(0.5, 2.0, 14.0, 0.9):.4f}")
        0.0014
    """
    require_finite("stiffness_n_per_m", stiffness_n_per_m, above=0.0)
    require_finite("damping_ns_per_m", damping_ns_per_m, least=0.0)
    impulse, time = np.asarray(impulse_ns, float), np.asarray(stance_s, float)
    slow = 2.0 * damping_ns_per_m / stiffness_n_per_m
    cubed = (time + slow) ** 3 - slow**3
    return 12.0 * damping_ns_per_m * impulse**2 / (stiffness_n_per_m**2 * cubed)


def bound(body: Walker, speed_m_per_s: ArrayLike, stance_s: ArrayLike) -> np.ndarray:
    """Return a cost below which no periodic gait of a level torso, with stances of at most τ, is
    possible at this speed.

    n legs bear the weight together: n · loss(m g τ / n) / (τ m g v), with `stance_loss_j`.

    Args:
        body: the walker.
        speed_m_per_s: v [m/s].
        stance_s: τ, the longest time for which a foot is on the ground [s].

    Returns:
        The cost of transport, of the common shape of v and τ.

    Source: docs/studies/legs_limit.md.

    Example:
        >>> print(f"{bound(Walker(), 0.4, 1.0):.3f}")
        0.024
    """
    legs, weight = sum(body.present), body.weight_n
    time = np.asarray(stance_s, float)
    loss = stance_loss_j(
        weight * time / legs, time, body.stiffness_z_n_per_m, body.damping_z_ns_per_m
    )
    return legs * loss / (time * weight * np.asarray(speed_m_per_s, float))


@cache
def limit_table() -> pd.DataFrame:
    """Return the kept limits of quadruped C.

    What is not known of a controller's gait is NaN. The columns:

    - `feet`: what the feet may do: on C's `ellipse` at any phase, or `free` within reach
    - `speed`: speed [√(g l0)]
    - `cost_of_transport`: the least found at this speed
    - `omega`: its stride frequency ω [√(g/l0)]
    - `gait`: its gait, by the middles of its stances
    - `duty_factor`: share of the stride on the ground, mean of the legs
    - `longest_stance`: the longest time of a foot on the ground [√(l0/g)]
    - `hind_lag`: lag of the left fore leg behind the left hind leg [cycles]
    - `flight`: share of the stride without a foot on the ground
    - `source`: `search`, or the learned controller that showed it
    """
    return pd.read_csv(KEPT)


def limit(speed: ArrayLike, feet: str = "free") -> np.ndarray:
    """Return the least cost of transport found for quadruped C at a speed: found, not proved.

    Of "free" feet, which may be commanded anywhere within 0.4 l0 of their hips, fore and aft; or of
    feet on C's own "ellipse", whose phases may be any function of time, as with learned A, R and G.
    Between the speeds of the table, no more than a straight line in log CoT.

    Args:
        speed: v [√(g l0)], any shape.
        feet: "free" or "ellipse".

    Returns:
        The cost, NaN beyond the table's speeds.

    Raises:
        TegotaeError: for other feet.

    Example:
        >>> bool(limit(0.3) <= limit(0.3, "ellipse"))
        True
    """
    require_known("kind of feet", feet, FEET)
    table = limit_table()
    table = table[table.feet == feet]
    speeds, cost = table.speed, np.log(table.cost_of_transport)
    return np.exp(np.interp(np.asarray(speed, float), speeds, cost, left=np.nan, right=np.nan))


def limit_share(speed: ArrayLike, cost_of_transport: ArrayLike, feet: str = "free") -> np.ndarray:
    """Return the limit over the cost of a gait of quadruped C: 1 of the best that is known.

    Args:
        speed: v [√(g l0)].
        cost_of_transport: of the gait.
        feet: as for `limit`.

    Returns:
        The share, NaN beyond the table's speeds.

    Example:
        >>> bool(limit_share(0.3, 0.5) < 1.0)
        True
    """
    return limit(speed, feet) / np.asarray(cost_of_transport, float)
