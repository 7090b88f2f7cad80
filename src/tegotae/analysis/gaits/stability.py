"""Stability of gaits: the return map of the lags around a gait, and its multipliers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import (
    TegotaeError,
    require_count,
    require_finite,
    unknown,
)
from tegotae.analysis.gaits.map import (
    OMEGA,
    Axis,
    Setting,
    check_axis,
    lanes_at,
    settings,
)
from tegotae.measures.gaits.lags import Sections
from tegotae.measures.gaits.names import TOLERANCE, distance, patterns_for
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import Step
from tegotae.systems.legged import Legged

KICK = 0.005
"""How far phases are kicked [cycles]."""
SKIP, CYCLES = 4, 8
"""How many cycles after the kick are left out, and how many are then fitted."""
LINEAR = 0.1
"""From where deviations are beyond this on, they are no longer small, and not fitted [cycles]."""
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


def fit_return_map(deviation: ArrayLike, *, most: float = LINEAR) -> ReturnMap:
    """The linear map that takes deviations of lags to those a cycle later, by least squares.

    Args:
        deviation: of the legs other than the reference leg, kick by kick, [cycles, legs, kicks]
            [cycles]; NaN where unknown.
        most: from where a kick's deviations have a larger entry on, they are left out.

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
    small = np.nan_to_num(np.abs(deviation), nan=np.inf).max(axis=1) <= most
    known = np.logical_and.accumulate(small, axis=0)
    now = np.moveaxis(deviation[:-1], 1, 0).reshape(legs, -1)
    then = np.moveaxis(deviation[1:], 1, 0).reshape(legs, -1)
    both = (known[:-1] & known[1:]).ravel()
    now, then = now[:, both], then[:, both]
    if np.linalg.matrix_rank(now) < legs:
        nothing = np.full((legs, legs), np.nan)
        return ReturnMap(nothing, np.full(legs, np.nan + 0j), np.nan)
    jacobian = np.linalg.lstsq(now.T, then.T, rcond=None)[0].T
    values = np.linalg.eigvals(jacobian)
    left_over = np.linalg.norm(then - jacobian @ now) / np.linalg.norm(then)
    return ReturnMap(jacobian, values[np.argsort(-np.abs(values))], float(left_over))


@dataclass(frozen=True)
class StabilityBranch:
    """One gait along a parameter."""

    gait: str
    """Its name."""
    lag: np.ndarray
    """Its lags when the kicks come [cycles], [values, limbs]; NaN where it is not found."""
    maps: tuple[ReturnMap, ...]
    """Return maps at the values; all NaN where the gait is not found."""
    stays: np.ndarray
    """Whether the body, unkicked, is still in this gait in the end, [values]."""

    @property
    def largest(self) -> np.ndarray:
        """The largest modulus of the multipliers, [values]."""
        return np.array([each.largest for each in self.maps])


@dataclass(frozen=True)
class Crossing:
    """Where a gait's largest multiplier crosses one."""

    gait: str
    at: float
    """The parameter there, between two values by a straight line."""
    loses: bool
    """Whether the gait is unstable beyond it."""


@dataclass(frozen=True)
class GaitStability:
    """Return maps of gaits along a parameter."""

    legged: Legged
    """The system."""
    over: Axis
    """The parameter."""
    branches: tuple[StabilityBranch, ...]
    """The gaits."""
    refused: tuple[str, ...]
    """Why there is no body at a value; empty if there is one."""

    @property
    def able(self) -> np.ndarray:
        """At which values there is a body, [values]."""
        return np.array([not each for each in self.refused])

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        """Where multipliers cross one."""
        return tuple(
            found
            for branch in self.branches
            for found in crossings(self.over.values, branch.largest, branch.gait)
        )


def crossings(values: Sequence[float], largest: ArrayLike, gait: str = "") -> tuple[Crossing, ...]:
    """Where the largest multiplier crosses one, between neighbouring values that have one.

    Args:
        values: of the parameter, rising.
        largest: the largest modulus at each; NaN where unknown.
        gait: whose it is.

    Example:
        >>> crossings([1.0, 2.0, 3.0], [0.5, 0.75, 1.25], "trot")
        (Crossing(gait='trot', at=2.5, loses=True),)
    """
    points = zip(values, np.asarray(largest, float).tolist(), strict=True)
    return tuple(
        Crossing(gait, float(v + (w - v) * (1.0 - a) / (b - a)), b > a)
        for (v, a), (w, b) in pairwise(points)
        if (a < 1.0) != (b < 1.0) and np.isfinite([a, b]).all()
    )


def stability(
    legged: Legged,
    over: Axis,
    gaits: Sequence[str] | None = None,
    *,
    kick: float = KICK,
    pairs: int = 8,
    skip: int = SKIP,
    cycles: int = CYCLES,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
) -> GaitStability:
    """How deviations of the lags from gaits grow or decay, cycle by cycle.

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
        >>> from tegotae.analysis.gaits import system
        >>> near = Axis("inertia_ratio", (0.98, 1.02))
        >>> found = stability(system("bar-light"), near, ["in phase"])
        >>> [round(each.at, 2) for each in found.crossings]
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
    made = settings(legged, [{over.name: value} for value in over.values])
    able = [each for each in made if each.body is not None]
    if not able:
        raise TegotaeError(f"no value of {over.name} has a body: {made[0].refused}")

    kicks = _kicks(limbs, pairs, kick, seed)
    lags = np.stack([lag for _, lag in released], axis=1)
    cut = timing.n_frames // 2
    sections = Sections(cut, skip + cycles + 1, legged.reference)
    lag, late = _run(legged, able, lags, kicks, cut, sections, timing)

    def branch(number: int, name: str, pattern: np.ndarray) -> StabilityBranch:
        maps, stays, at = [], [], []
        for each in made:
            if each.body is None:
                maps.append(fit_return_map(np.full((2, limbs - 1, 1), np.nan)))
                stays.append(False)
                at.append(np.full(limbs, np.nan))
                continue
            own = able.index(each)
            maps.append(_map(lag[:, :, own, number], pattern, legged.reference, skip, tolerance))
            stays.append(bool(_near(late[:, own, number, :1], pattern, tolerance)[0]))
            there = _near(lag[0, :, own, number, :1], pattern, tolerance)[0]
            at.append(np.where(there, lag[0, :, own, number, 0], np.nan))
        return StabilityBranch(name, np.array(at), tuple(maps), np.array(stays))

    branches = tuple(branch(i, *each) for i, each in enumerate(released))
    return GaitStability(legged, over, branches, tuple(each.refused for each in made))


def _patterns(legged: Legged, gaits: Sequence[str] | None) -> list[tuple[str, np.ndarray]]:
    """Names and lags of the gaits; of those with a mirror image, one."""
    found: dict[str, np.ndarray] = {}
    for pattern in patterns_for(legged.names):
        lag = np.array([pattern.lags[leg] for leg in legged.names])
        found.setdefault(pattern.name, (lag - lag[legged.reference]) % 1.0)
    for name in gaits or ():
        if name not in found:
            raise unknown(f"gait of {legged.body.limbs} legs", name, found)
    return [(name, found[name]) for name in (gaits or found)]


def _kicks(limbs: int, pairs: int, kick: float, seed: int) -> np.ndarray:
    """No kick, then pairs of opposite ones [cycles], [limbs, 1 + 2 pairs]."""
    drawn = np.random.default_rng(seed).normal(size=(limbs, pairs))
    drawn *= kick / np.abs(drawn).max(axis=0)
    return np.concatenate([np.zeros((limbs, 1)), drawn, -drawn], axis=1)


def _run(
    legged: Legged,
    able: list[Setting],
    lags: np.ndarray,
    kicks: np.ndarray,
    cut: int,
    sections: Sections,
    timing: Timing,
) -> tuple[np.ndarray, np.ndarray]:
    """Lags at the sections after the kicks, and those in the end, [..., values, gaits, kicks]."""
    limbs, gaits = lags.shape
    shape = len(able), gaits, kicks.shape[1]
    where = [each for each in able for _ in range(gaits * kicks.shape[1])]
    phase = np.broadcast_to(-2.0 * np.pi * lags[:, None, :, None], (limbs, *shape))
    kicked = np.broadcast_to(kicks[:, None, None, :], (limbs, *shape)).reshape(limbs, -1)
    frames = min(_KICK_FRAMES, cut)
    long_s, end_s = frames * timing.frame_s, cut * timing.frame_s
    omega = np.array([each.at.get(OMEGA, legged.omega) for each in where])
    faster = omega[None] + 2.0 * np.pi * kicked / long_s
    weights, scenario = lanes_at(
        legged,
        where,
        phase.reshape(limbs, -1) % (2.0 * np.pi),
        changes={OMEGA: Step(faster, end_s - long_s, end_s)},
    )
    engine = legged.engine(sections, timing)
    found, late = engine.run(weights, scenario, legged.body, dtype="float64")
    return found.reshape(*found.shape[:2], *shape), late.reshape(limbs, *shape)


def _map(
    lag: np.ndarray, pattern: np.ndarray, reference: int, skip: int, tolerance: float
) -> ReturnMap:
    """The return map of lags [cycles, limbs, kicks], the first unkicked, then pairs."""
    others = [leg for leg in range(lag.shape[1]) if leg != reference]
    pairs = (lag.shape[2] - 1) // 2
    up, down = lag[skip:, others, 1 : 1 + pairs], lag[skip:, others, 1 + pairs :]
    deviation = 0.5 * ((up - down + 0.5) % 1.0 - 0.5)
    if not _near(lag[0, :, :1], pattern, tolerance)[0]:
        deviation = np.full_like(deviation, np.nan)
    return fit_return_map(deviation)


def _near(lag: np.ndarray, pattern: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether lags [limbs, lanes] are those of a pattern [limbs], or of its neighbourhood."""
    off = distance(lag, pattern[:, None])
    return np.nan_to_num(off, nan=np.inf) <= tolerance
