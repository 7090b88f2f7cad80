"""The return map of the apex section: its fixed point, and the Floquet multipliers there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_POINTS
from tegotae.analysis.maps import turn
from tegotae.analysis.orbit import Orbit, hops_of, oscillator_state_names, require_enterable
from tegotae.systems.controller_file import SavedController

NUMERICAL = 5e-6
"""Distances below this, in m and rad, are those of the simulation's own errors."""

_MOST_OFF = 1.0  # what a disturbance may be, in m and rad
_NEWTON_STEPS = 6
_CLOSE = 1e-8  # of the fixed point, in m and rad
_SINGULAR = 1e6  # condition number
_ASTRAY = 0.1  # from a point of the orbit, in m and rad

Map = Callable[[np.ndarray], np.ndarray]
"""Function of points [n, d] that returns their images [n, d]; NaN where there is none."""


@dataclass(frozen=True)
class Poincare:
    """A limit cycle as a fixed point of the return map x → P(x) on the apex section.

    A point of the section is x = (y, φ), height [m] and phase [rad] at an apex (ẏ = 0), or x = y
    without an oscillator; an oscillator with more state adds it (`Oscillator.STATE`). P takes it to
    the k-th apex after it, k being the cycle's period in hops.
    """

    fixed_point: np.ndarray
    """x* = P(x*), shape [d]."""
    refined: bool
    """True if Newton's method found it; else it is the apex at which the rollout had settled."""
    jacobian: np.ndarray
    """∂P/∂x at x*, shape [d, d]."""
    multipliers: np.ndarray
    """Its eigenvalues, the Floquet multipliers, largest modulus first; complex, shape [d]."""
    hops: int
    """Period k [hops]."""
    period_s: float
    """Period T [s]."""
    nudged: np.ndarray
    """Points x_n after a nudge off x*, one per turn of the cycle, shape [turns, d]."""
    distance: np.ndarray
    """|x_n - x*|, in m and rad, shape [turns]."""
    observed: float
    """Mean factor by which the distance shrinks per turn, late; NaN if it cannot be measured."""

    @property
    def decay_s(self) -> float:
        """Time in which a disturbance shrinks to 1/e, T / -ln |λ| [s]; infinite if it grows."""
        modulus = abs(self.multipliers[0])
        return float(-self.period_s / np.log(modulus)) if modulus < 1.0 else np.inf

    @property
    def summary(self) -> pd.DataFrame:
        """The multipliers and their moduli, as texts."""
        texts = [f"{x.real:.4f}" if x.imag == 0.0 else f"{x:.4f}" for x in self.multipliers]
        table = {"Floquet multiplier": texts, "|λ|": np.abs(self.multipliers).round(4)}
        return pd.DataFrame(table).set_index("Floquet multiplier")

    @property
    def notes(self) -> list[str]:
        """The decay of a disturbance, in sentences."""
        notes = []
        if not self.refined:
            notes.append(
                "the fixed point was not refined; the apex at which the gait settled replaces it"
            )
        if np.isfinite(self.observed):
            notes.append(f"observed decay: {self.observed:.4f} per turn")
        if np.isfinite(self.decay_s):
            notes.append(f"a disturbance shrinks to 1/e in {self.decay_s:.3f} s")
        return notes


def poincare_section(
    saved: SavedController,
    orbit: Orbit,
    *,
    step: float = 1e-4,
    nudge: float = 1e-2,
    turns: int = 40,
    tick_s: float = 1e-4,
) -> Poincare:
    """Return the Floquet multipliers of a limit cycle, and the decay that is observed beside them.

    The fixed point is refined by Newton's method, and the Jacobian is taken by central differences,

        J_ij = (P_i(x* + ε e_j) - P_i(x* - ε e_j)) / 2ε.

    All multipliers inside the unit circle: the gait is stable, and disturbances shrink by |λ₁| per
    turn of the cycle. The multiplier 1, of a shift along the cycle, has no part in the section.

    Args:
        saved: the controller, its weights, frequency and body.
        orbit: its limit cycle (`find_orbit`).
        step: ε, in m and rad.
        nudge: how far from the fixed point the observed decay starts, in m and rad.
        turns: how many turns of the cycle it is watched for.
        tick_s: control period in continuous time [s]; shorter than elsewhere, for differences of
            near rollouts.

    Raises:
        TegotaeError: for steps that are not positive, or a cycle from which a step leads to no hop.

    Reference: S. H. Strogatz, Nonlinear Dynamics and Chaos, section 8.7.
    """
    require_enterable(saved, "a Poincaré section")
    check_disturbances(step, nudge, turns)
    with_phase = saved.controller.oscillator is not None
    start = np.array(
        [
            *[orbit.apex_height_m[0], orbit.apex_phase_rad[0]][: 1 + with_phase],
            *(orbit.apex_oscillator_state[name][0] for name in oscillator_state_names(saved)),
        ]
    )

    def iterate(points: np.ndarray, cycles: int) -> np.ndarray:
        return _apexes(saved, orbit, points, cycles, tick_s)

    fixed, matrix, refined = fixed_point(lambda points: iterate(points, 1)[0], start, step)
    if not np.all(np.isfinite(matrix)):
        raise TegotaeError(
            f"a step of {step:g} off the limit cycle leads to no hop; use a smaller step"
        )
    values = np.linalg.eigvals(matrix).astype(complex)
    values = values[np.argsort(-np.abs(values))]
    begin = fixed + nudge * np.eye(len(fixed))[0]
    nudged = np.concatenate([begin[None], iterate(begin[None], turns)[:, 0]])
    distance = np.linalg.norm(_differences(nudged, fixed), axis=-1)
    return Poincare(
        fixed_point=fixed,
        refined=refined,
        jacobian=matrix,
        multipliers=values,
        hops=orbit.hops,
        period_s=orbit.period_s,
        nudged=nudged,
        distance=distance,
        observed=observed_factor(distance),
    )


def check_disturbances(step: float, nudge: float, turns: int) -> None:
    """Raise `TegotaeError` for steps or a nudge [m, rad] out of their range, or too few turns."""
    require_finite("step", step, above=0.0, most=_MOST_OFF)
    require_finite("nudge", nudge, above=NUMERICAL, most=_MOST_OFF)
    require_count("turns", turns, least=3, most=MOST_POINTS)


def linearised(image: Map, point: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return P(x), shape [d], and ∂P/∂x by central differences, shape [d, d].

    Example:
        >>> matrix = np.array([[0.5, 0.1], [-0.2, 0.3]])
        >>> at, slope = linearised(lambda x: x @ matrix.T, np.array([1.0, 2.0]), 1e-3)
        >>> at.round(6), slope.round(6)
        (array([0.7, 0.4]), array([[ 0.5,  0.1],
               [-0.2,  0.3]]))
    """
    steps = step * np.eye(len(point))
    images = image(np.concatenate([point[None], point + steps, point - steps]))
    ahead, behind = np.split(images[1:], 2)
    return images[0], (_differences(ahead, behind) / (2.0 * step)).T


def fixed_point(image: Map, start: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, bool]:
    """Find x* = P(x*) near `start` by Newton's method; return it, ∂P/∂x there, and whether it
    converged.

    Where Newton's method leads astray it is `start` itself.

    Example:
        >>> at, slope, found = fixed_point(np.cos, np.array([0.7]), 1e-4)
        >>> f"{at[0]:.6f} {slope[0, 0]:.6f} {found}"
        '0.739085 -0.673612 True'
    """
    point, at_start = start, linearised(image, start, step)
    current, matrix = at_start
    for _ in range(_NEWTON_STEPS):
        miss = _differences(current, point)
        if np.linalg.norm(miss) < _CLOSE:
            return point, matrix, True
        slope = np.eye(len(point)) - matrix
        defined = np.all(np.isfinite(miss)) and np.all(np.isfinite(slope))
        if not defined or np.linalg.cond(slope) > _SINGULAR:
            return start, at_start[1], False
        point = point + np.linalg.solve(slope, miss)
        if np.linalg.norm(_differences(point, start)) > _ASTRAY:
            return start, at_start[1], False
        current, matrix = linearised(image, point, step)
    return point, matrix, bool(np.linalg.norm(_differences(current, point)) < _CLOSE)


def observed_factor(distance: np.ndarray) -> float:
    """Return the factor per turn of a decay, from a line through the logarithm of its last part.

    The last part is below a tenth of the first distance and above what is numerical; where it has
    fewer than three points, the decay from the first distance on.

    Example:
        >>> f"{observed_factor(0.01 * 0.8 ** np.arange(40)):.3f}"
        '0.800'
    """
    turns = np.arange(len(distance))
    above = np.isfinite(distance) & (distance > NUMERICAL)
    # Only up to the first distance that is numerical.
    above &= np.cumprod(above, dtype=int).astype(bool)
    late = above & (distance < 0.1 * distance[0])
    counts = late if late.sum() >= 3 else above
    if counts.sum() < 3:
        return np.nan
    return float(np.exp(np.polyfit(turns[counts], np.log(distance[counts]), 1)[0]))


def _differences(points: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return the difference of points of the section, phases modulo 2π."""
    difference = np.array(points - references)
    if difference.shape[-1] > 1:
        difference[..., 1] = turn(difference[..., 1])
    return difference


def _apexes(
    saved: SavedController, orbit: Orbit, points: np.ndarray, cycles: int, tick_s: float
) -> np.ndarray:
    """Return the section's points after 1 ... `cycles` turns, shape [cycles, n, d]."""
    duration_s = (1.5 * cycles + 0.5) * orbit.period_s
    table, state = hops_of(
        saved,
        saved.system.timing_over(duration_s, tick_s=tick_s, frame_s=20 * tick_s),
        height_m=points[:, 0],
        velocity_m_per_s=0.0,
        phase_rad=points[:, 1] if points.shape[1] > 1 else 0.0,
        oscillator_state=dict(zip(oscillator_state_names(saved), points.T[2:], strict=True)),
    )
    rows = orbit.hops * np.arange(1, cycles + 1) - 1
    beyond = rows >= len(table.time_s)
    rows = np.minimum(rows, len(table.time_s) - 1)
    rows_of_apexes = np.stack([x[rows] for x in (table.height_m, table.phase_rad, *state)], axis=-1)
    rows_of_apexes[beyond] = np.nan
    return rows_of_apexes[..., : points.shape[1]]


def transient(saved: SavedController, *, duration_s: float = 60.0) -> np.ndarray:
    """Return the section's points from a release on: height [m] and phase [rad] of each hop, [hops,
    d].

    Args:
        saved: the system and its weights.
        duration_s: simulated time [s].
    """
    table, _ = hops_of(saved, saved.system.timing_over(duration_s))
    number = int(table.n_hops[0])
    points = np.stack([table.height_m[:number, 0], table.phase_rad[:number, 0]], axis=-1)
    return points if saved.controller.oscillator is not None else points[:, :1]
