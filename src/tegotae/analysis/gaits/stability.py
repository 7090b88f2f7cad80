"""Stability of gaits: the return map of the lags around a gait, and its multipliers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count, require_finite, require_known
from tegotae.analysis.gaits.map import OMEGA, Axis, Setting, check_axis, lanes_at, settings
from tegotae.measures.gaits.lags import Sections
from tegotae.measures.gaits.names import TOLERANCE, distance, patterns_for
from tegotae.measures.statistics import UNDEFINED
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Step
from tegotae.systems.legged import Legged

_KICK = 0.005
"""Size of the phase perturbation [cycles]."""
SKIP, CYCLES = 4, 8
"""Numbers of cycles after the perturbation that are skipped, and then fitted."""
_LINEAR = 0.1
"""Largest deviation that is small enough to be fitted [cycles]."""
_KICK_FRAMES = 40


class ReturnMap(NamedTuple):
    """A linear map of lag deviations from one cycle to the next, δ' = M δ."""

    jacobian: np.ndarray
    """M, of the legs other than the reference leg, [legs, legs]."""
    multipliers: np.ndarray
    """Its eigenvalues, the largest first, [legs]."""
    residual: float
    """Share of the deviations that M does not explain: |δ' - M δ| / |δ'|, root mean square."""

    @property
    def largest(self) -> float:
        """The largest of the multipliers' moduli: above 1 the gait is not stable."""
        return float(np.abs(self.multipliers[0]))


def fit_return_map(deviation: ArrayLike) -> ReturnMap:
    """Return the linear map that takes deviations of lags to those a cycle later, by least squares.

    Args:
        deviation: of the legs other than the reference leg, kick by kick, [cycles, legs, kicks]
            [cycles]; NaN where unknown. From where a kick's deviations have an entry above 0.1 on,
            they are left out.

    Returns:
        All NaN if fewer deviations are known than legs.

    Example:
        >>> jacobian = np.diag([0.5, 0.9])
        >>> path = [np.eye(2)]
        >>> for _ in range(3):
        ...     path.append(jacobian @ path[-1])
        >>> fit_return_map(0.01 * np.array(path)).multipliers.real.round(6).tolist()
        [0.9, 0.5]
    """
    deviation = np.asarray(deviation, float)
    legs = deviation.shape[1]
    small = np.nan_to_num(np.abs(deviation), nan=np.inf).max(axis=1) <= _LINEAR
    usable = np.logical_and.accumulate(small, axis=0)
    current = np.moveaxis(deviation[:-1], 1, 0).reshape(legs, -1)
    following = np.moveaxis(deviation[1:], 1, 0).reshape(legs, -1)
    pairs = (usable[:-1] & usable[1:]).ravel()
    current, following = current[:, pairs], following[:, pairs]
    if np.linalg.matrix_rank(current) < legs:
        undefined = np.full((legs, legs), np.nan)
        return ReturnMap(undefined, np.full(legs, np.nan + 0j), np.nan)
    jacobian = np.linalg.lstsq(current.T, following.T, rcond=None)[0].T
    values = np.linalg.eigvals(jacobian)
    left_over = np.linalg.norm(following - jacobian @ current) / np.linalg.norm(following)
    return ReturnMap(jacobian, values[np.argsort(-np.abs(values))], float(left_over))


@dataclass(frozen=True)
class GaitStability:
    """Return maps of gaits along a parameter."""

    legged: Legged
    """The system."""
    over: Axis
    """The parameter."""
    frame: pd.DataFrame
    """A row a gait and value: the `largest` modulus of the multipliers, the share `unexplained`,
    whether the body, unkicked, `stays` in the gait to the end, why there is no body (`refused`),
    the lags when the kicks come, NaN where the gait is not found, and the multipliers."""
    jacobians: dict[str, np.ndarray]
    """M by the gaits' names, [values, legs, legs]."""

    @property
    def crossings(self) -> pd.DataFrame:
        """Return the crossings of one by the largest multiplier of a `gait`: the parameter there,
        `at`, between two values by a straight line; and whether the gait `loses` its stability
        beyond it."""
        of_gaits = self.frame.groupby("gait", sort=False)
        rows = [
            (gait, *crossing)
            for gait, group in of_gaits
            for crossing in crossings(group[self.over.name].tolist(), group.largest)
        ]
        return pd.DataFrame(rows, columns=["gait", "at", "loses"])

    @property
    def summary(self) -> pd.DataFrame:
        """Largest multiplier and unexplained share as texts, one row per value and one column
        per gait.
        """
        frame = self.frame
        texts = [
            UNDEFINED if math.isnan(a) else f"{a:.3f}, {b:.3f}"
            for a, b in zip(frame["largest"], frame["unexplained"], strict=True)
        ]
        table = frame.assign(text=texts).pivot(index=self.over.name, columns="gait", values="text")
        table = table[[*self.jacobians]].add_suffix(": largest, unexplained")
        return table.set_index(table.index.map("{:.4g}".format))

    @property
    def notes(self) -> list[str]:
        """The changes of stability along the parameter, in sentences."""
        changes = [
            f"{gait} {'loses' if loses else 'gains'} its stability at {self.over.name} {at:.3g}"
            for gait, at, loses in self.crossings.itertuples(index=False)
        ]
        ends, frame = [], cast(Any, self.frame)
        for gait, rows in frame[frame["refused"] == ""].groupby("gait", sort=False):
            values, stays = rows[self.over.name].to_numpy(), rows["stays"].to_numpy()
            for i in np.flatnonzero(np.diff(stays.astype(int))):
                side = "below" if stays[i] else "above"
                between = f"{values[i]:.3g} … {values[i + 1]:.3g}"
                ends.append(f"{gait}, simulated to the end: stays {side} {between}")
        return [*changes, *ends, *([] if changes else [_NO_CROSSING])]


_NO_CROSSING = "no multiplier crosses one between neighbouring values"


def crossings(values: Sequence[float], largest: ArrayLike) -> list[tuple[float, bool]]:
    """Return the positions where the largest multiplier crosses one, and whether upwards, between
    neighbours.

    Args:
        values: of the parameter, rising.
        largest: the largest modulus at each; NaN where unknown.

    Example:
        >>> crossings([1.0, 2.0, 3.0], [0.5, 0.75, 1.25])
        [(2.5, True)]
    """
    points = zip(values, np.asarray(largest, float).tolist(), strict=True)
    return [
        (v + (w - v) * (1.0 - a) / (b - a), b > a)
        for (v, a), (w, b) in pairwise(points)
        if (a < 1.0) != (b < 1.0) and np.isfinite([a, b]).all()
    ]


def stability(
    legged: Legged,
    over: Axis,
    gaits: Sequence[str] | None = None,
    *,
    kick: float = _KICK,
    pairs: int = 8,
    skip: int = SKIP,
    cycles: int = CYCLES,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
) -> GaitStability:
    """Measure the growth or decay of small deviations of the lags from gaits, cycle by cycle.

    At each value of the parameter the body is released at the lags of the gait, and runs on for
    half the time. If it is in that gait then, the phases of its legs are kicked: for a moment each
    leg's ω is another, in pairs of lanes by as much up as down. The kicked lags are measured at the
    sections where the reference leg's phase passes zero; half the differences of such pairs are
    deviations δ. The first cycles also show what the kick did to the body's motion, and are left
    out; over those that follow, δ' = M δ is fitted by least squares. The eigenvalues of M are the
    multipliers per cycle: below one in modulus deviations decay.

    All is done in double precision, in one batch.

    Args:
        legged: the body and what drives it.
        over: the parameter.
        gaits: names of gaits of so many legs; all of them by default.
        kick: how far the most kicked phase goes [cycles].
        pairs: how many directions are kicked, at random; at least one for each other leg.
        skip: how many cycles after the kick are left out.
        cycles: how many are then fitted.
        seed: of the directions.
        tolerance: how far lags may be from a gait's pattern [cycles].
        timing: of each rollout; that of the system by default.

    Raises:
        TegotaeError: for a parameter or a gait that the system does not have, no cycles, or a body
            that cannot be at any value.

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> near = Axis("inertia_ratio", (0.98, 1.02))
        >>> found = stability(system("bar-light"), near, ["in phase"])
        >>> found.crossings["at"].round(2).tolist()
        [1.0]
    """
    limbs = legged.body.limbs
    check_axis(legged, over)
    require_finite("kick", kick, above=0.0, most=0.25)
    require_count("pairs", pairs, least=limbs - 1, most=1000)
    require_count("skip", skip, least=0, most=1000)
    require_count("cycles", cycles, most=1000)
    if legged.omega is None:
        raise TegotaeError("the controller has no oscillator, whose phase could be kicked")
    released = _patterns(legged, gaits)
    timing = timing or legged.timing
    timing = dataclasses.replace(timing, frame_s=2.0 * timing.tick_s)
    cells = settings(legged, [{over.name: value} for value in over.values])
    if all(setting.body is None for setting in cells):
        raise TegotaeError(f"no value of {over.name} has a body: {cells[0].refused}")
    kicks = _kicks(limbs, pairs, kick, seed)
    sections = Sections(timing.n_frames // 2, skip + cycles + 1, legged.reference)
    lag, late = _run(legged, cells, list(released.values()), kicks, sections, timing)
    rows, jacobians = [], {}
    for number, (name, pattern) in enumerate(released.items()):
        maps = []
        for i, setting in enumerate(cells):
            lags, end = lag[:, :, i, number], late[:, i, number, 0]
            near = _near(lags[0, :, 0], pattern, tolerance)
            lags = lags if near else np.full_like(lags, np.nan)
            return_map = _map(lags, legged.reference, skip)
            row = {"gait": name, over.name: over.values[i], "largest": return_map.largest}
            row |= {"unexplained": return_map.residual, "stays": _near(end, pattern, tolerance)}
            row |= {"refused": setting.refused}
            row |= {f"lag_cycles_{leg}": lags[0, k, 0] for k, leg in enumerate(legged.names)}
            for k, multiplier in enumerate(return_map.multipliers, 1):
                row[f"multiplier_{k}_real"] = multiplier.real
                row[f"multiplier_{k}_imaginary"] = multiplier.imag
            rows.append(row)
            maps.append(return_map.jacobian)
        jacobians[name] = np.array(maps)
    return GaitStability(legged, over, pd.DataFrame(rows), jacobians)


def _patterns(legged: Legged, gaits: Sequence[str] | None) -> dict[str, np.ndarray]:
    """Return the lags of the gaits by name, one for those with a mirror image."""
    patterns: dict[str, np.ndarray] = {}
    for pattern in patterns_for(legged.names):
        lag = np.array([pattern.lags[leg] for leg in legged.names])
        patterns.setdefault(pattern.name, (lag - lag[legged.reference]) % 1.0)
    for name in gaits or ():
        require_known(f"gait of {legged.body.limbs} legs", name, patterns)
    return {name: patterns[name] for name in gaits or patterns}


def _kicks(limbs: int, pairs: int, kick: float, seed: int) -> np.ndarray:
    """Return no kick, then pairs of opposite kicks [cycles], [limbs, 1 + 2 pairs]."""
    drawn = np.random.default_rng(seed).normal(size=(limbs, pairs))
    drawn *= kick / np.abs(drawn).max(axis=0)
    return np.concatenate([np.zeros((limbs, 1)), drawn, -drawn], axis=1)


def _run(
    legged: Legged,
    cells: Sequence[Setting],
    lags: Sequence[np.ndarray],
    kicks: np.ndarray,
    sections: Sections,
    timing: Timing,
) -> list[np.ndarray]:
    """Return the lags at the sections after the kicks, and those in the end, [..., values, gaits,
    kicks].

    NaN at values without a body.
    """
    possible = [setting.body is not None for setting in cells]
    limbs = len(kicks)
    shape = sum(possible), len(lags), kicks.shape[1]
    where = [
        setting for setting in cells if setting.body is not None for _ in range(np.prod(shape[1:]))
    ]
    lag = np.stack(lags, axis=1)[:, None, :, None]
    phase = np.broadcast_to(-2.0 * np.pi * lag, (limbs, *shape)).reshape(limbs, -1)
    kicked = np.broadcast_to(kicks[:, None, None, :], (limbs, *shape)).reshape(limbs, -1)
    end_s = sections.first * timing.frame_s
    long_s = min(_KICK_FRAMES * timing.frame_s, end_s)
    omega = np.array([setting.at.get(OMEGA, legged.omega) for setting in where])
    faster = Step(omega[None] + 2.0 * np.pi * kicked / long_s, end_s - long_s, end_s)
    weights, scenario = lanes_at(legged, where, phase % (2.0 * np.pi), changes={OMEGA: faster})
    rollout = legged.rollout(sections, timing)
    results = rollout.run(weights, scenario, legged.body, dtype="float64")

    def at_all(x: np.ndarray) -> np.ndarray:
        padded = np.full((*x.shape[:-1], len(cells), *shape[1:]), np.nan)
        padded[..., possible, :, :] = x.reshape(*x.shape[:-1], *shape)
        return padded

    return [at_all(x) for x in results]


def _map(lag: np.ndarray, reference: int, skip: int) -> ReturnMap:
    """Return the return map of lags [cycles, limbs, kicks]: the first without a kick, then in
    pairs.
    """
    other_legs = [leg for leg in range(lag.shape[1]) if leg != reference]
    pairs = (lag.shape[2] - 1) // 2
    up, down = lag[skip:, other_legs, 1 : 1 + pairs], lag[skip:, other_legs, 1 + pairs :]
    return fit_return_map(0.5 * ((up - down + 0.5) % 1.0 - 0.5))


def _near(lag: np.ndarray, pattern: np.ndarray, tolerance: float) -> bool:
    """Return whether lags are near those of a pattern, [limbs] both."""
    return bool(distance(lag[:, None], pattern[:, None])[0] <= tolerance)
