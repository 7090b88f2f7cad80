"""Sweeps of the frequency: slowly up a staircase and down another, and where the gait changes.

What differs between the way up and the way down is hysteresis: at such frequencies there are two
gaits, and which one it is depends on where the body comes from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_POINTS, MOST_RAD_PER_S
from tegotae.measures.gaits.lags import (
    circular_mean,
    drift,
    moved_until,
    rounding,
)
from tegotae.measures.gaits.names import (
    NO_GAIT,
    TOLERANCE,
    distance,
    gait_of,
)
from tegotae.measures.gaits.summary import (
    LEAST_FRAMES,
    Coordination,
    CoordinationSummary,
    coordination,
)
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.world import Staircase
from tegotae.systems.legged import Legged, lanes_of, random_phases

UP, DOWN = "up", "down"
DETUNING = 1e-4
"""By how much the legs' frequencies differ from the level's, relatively (standard deviation). Legs
that are exactly in phase stay so for ever, stable or not, unless something separates them."""
MEASURED = 0.5
"""Share of every level, its end, that is measured."""


@dataclass(frozen=True)
class Switch:
    """A change of gait along a sweep of one start: somewhere between two levels."""

    before: str
    after: str
    low: float
    """The lower of the two frequencies between which it lies [rad/s]."""
    high: float
    """The higher one [rad/s]."""


@dataclass(frozen=True)
class Hysteresis:
    """A change between two gaits that takes place elsewhere on the way up than on the way down."""

    slow: str
    """The gait at lower frequencies."""
    fast: str
    """The gait at higher ones."""
    up: tuple[float, float]
    """Between which levels the slow one gives way on the way up: from the lowest at which a start
    that changes was last seen in it, to the highest at which one was first seen in the other
    [rad/s]."""
    down: tuple[float, float]
    """Between which levels the fast one gives way on the way down [rad/s]."""
    width: tuple[float, float]
    """Between what up - down lies [rad/s]."""
    starts_up: int
    """How many starts change on the way up."""
    starts_down: int
    """How many do on the way down."""


@dataclass(frozen=True)
class GaitSweep:
    """What sweeps up and down have found; levels from the lowest frequency to the highest."""

    legged: Legged
    """The swept system."""
    omega: np.ndarray
    """The levels [rad/s], [levels]."""
    phase_rad: np.ndarray
    """Phases at release [rad], [limbs, starts]."""
    found: dict[str, Coordination]
    """By direction, "up" and "down": arrays [levels, (limbs,) starts]."""
    gait: dict[str, np.ndarray]
    """And names, [levels, starts]."""
    tolerance: float = TOLERANCE
    """How far lags may be from a named pattern's, and from those of the other way [cycles]."""

    @property
    def hysteresis(self) -> tuple[Hysteresis, ...]:
        """The changes of gait, and how far apart they are on the two ways."""
        return hysteresis(self.omega, self.gait[UP], self.gait[DOWN])

    @property
    def bistable(self) -> np.ndarray:
        """The levels at which the lags on the way up are others than on the way down [rad/s]."""
        return self.omega[differs(self.found[UP].lag, self.found[DOWN].lag, self.tolerance)]


@dataclass(frozen=True)
class LevelsSummary:
    """An `Engine`'s summary: the coordination at every level of a staircase, [levels, ...].

    Args:
        levels: how many levels of equal length the recording has.
        own: how each of them is summarised.
    """

    levels: int
    own: CoordinationSummary

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that are recorded for it."""
        return self.own.needs

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Coordination:
        """The coordination of every lane at every level, in the order in which they came.

        Times count from the begin of the level. How far lags have moved counts from the release,
        beside the drift of legs that do not feel each other, and what rounding makes of it.
        """
        frames = timing.n_frames // self.levels
        split = jax.tree.map(lambda x: x.reshape(self.levels, frames, *x.shape[1:]), trajectory)

        def of_level(level: Trajectory) -> Coordination:
            return coordination(
                level,
                body,
                frame_s=timing.frame_s,
                begins=round((1.0 - MEASURED) * frames),
                reference=self.own.reference,
                tolerance=self.own.tolerance,
                rhythm=self.own.rhythm,
            )

        found = jax.vmap(of_level)(split)
        begun = split.time_s[:, 0] - timing.frame_s
        lag = self.own.rhythm.lag(trajectory, self.own.reference)
        omega = jnp.broadcast_to(scenario.omega, lag.shape[1:])
        own_way = drift(omega, trajectory.time_s, self.own.reference)
        rounded = rounding(trajectory.time_s / timing.tick_s)
        ever = moved_until(lag - own_way, rounded)[frames - 1 :: frames]
        return found._replace(
            lock_time_s=found.lock_time_s - begun,
            fall_time_s=found.fall_time_s - begun,
            moved=jnp.where(jnp.isnan(found.moved), jnp.nan, ever),
        )


def sweep(
    legged: Legged,
    omega: ArrayLike,
    *,
    dwell_s: float,
    starts: int = 16,
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> GaitSweep:
    """Raise the frequency level by level, and in other lanes lower it, without a new release.

    The legs' frequencies differ by 1 in 10 000 (`DETUNING`): without that, a gait of legs that are
    exactly alike would outlive its stability.

    Args:
        legged: the body and what drives it; its own frequency does not count.
        omega: evenly spaced levels, from low to high [rad/s].
        dwell_s: how long each lasts [s]; the second half of it is measured.
        starts: how many releases, at the ends of the sweep, at random phases.
        seed: of the phases.
        tolerance: how far lags may be from a named pattern's [cycles].

    Raises:
        TegotaeError: for a controller without oscillator, fewer than two levels, uneven ones, or
            what the engine refuses.

    Example:
        >>> from tegotae.analysis.gaits import system
        >>> found = sweep(system("bar-light"), [7.5, 8.0], dwell_s=40.0, starts=2)
        >>> found.gait["down"].tolist()
        [['antiphase', 'antiphase'], ['antiphase', 'antiphase']]
    """
    levels = check_levels(omega)
    if legged.omega is None:
        raise TegotaeError("the controller has no oscillator, and so no frequency to sweep")
    timing = staircase_timing(legged.timing, len(levels), dwell_s)
    phase = random_phases(legged.body.limbs, starts, seed)
    step = levels[1] - levels[0]
    up = np.repeat([True, False], starts)
    off = DETUNING * np.random.default_rng([seed, 1]).normal(size=phase.T.shape).T
    scenario = legged.scenario(
        np.tile(phase, 2),
        changes={
            "omega": Staircase(
                np.where(up, step, -step), timing.duration_s / len(levels), float(len(levels))
            )
        },
    )._replace(omega=np.where(up, levels[0], levels[-1]) * (1.0 + np.tile(off, 2)))
    summary = LevelsSummary(len(levels), legged.summary())
    whole = lanes_of(legged.run(summary, scenario, timing))
    found = {
        UP: Coordination(*(x[..., :starts] for x in whole)),
        DOWN: Coordination(*(x[::-1, ..., starts:] for x in whole)),
    }
    gait = {
        way: np.stack(
            [
                gait_of(Coordination(*(x[level] for x in each)), legged.names, tolerance)
                for level in range(len(levels))
            ]
        )
        for way, each in found.items()
    }
    return GaitSweep(legged, levels, phase, found, gait, tolerance)


def check_levels(omega: ArrayLike) -> np.ndarray:
    """The levels of a sweep, if they can be: two at least, rising evenly.

    Raises:
        TegotaeError: if not.
    """
    levels = np.asarray(omega, float)
    require_count("levels", levels.size, least=2, most=MOST_POINTS)
    for level in levels:
        require_finite("a level of omega", level, above=0.0, most=MOST_RAD_PER_S)
    steps = np.diff(levels)
    if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * levels[-1]:
        raise TegotaeError(
            f"the levels of omega are {levels.tolist()}; they must rise by equal steps"
        )
    return levels


def staircase_timing(own: Timing, levels: int, dwell_s: float) -> Timing:
    """The timing of a staircase whose levels are whole frames.

    Raises:
        TegotaeError: for a level shorter than eight frames, or a run that is too long.
    """
    require_finite("dwell_s", dwell_s, above=0.0)
    frames = round(dwell_s / own.frame_s)
    if frames < LEAST_FRAMES:
        raise TegotaeError(
            f"dwell_s is {dwell_s:g}; it must be at least eight frames "
            f"({LEAST_FRAMES * own.frame_s:g} s)"
        )
    return Timing(duration_s=levels * frames * own.frame_s, tick_s=own.tick_s, frame_s=own.frame_s)


def differs(up: AnyArray, down: AnyArray, tolerance: float = TOLERANCE) -> np.ndarray:
    """Where the lags on the two ways differ, whatever they are called, [levels].

    That is where the circular means over the starts are farther apart than a tolerance.

    Args:
        up: lags on the way up, [levels, limbs, starts] [cycles].
        down: on the way down, levels in the same order.
        tolerance: as of a name [cycles].

    Example:
        >>> up, down = np.zeros((2, 2, 3)), np.zeros((2, 2, 3))
        >>> down[1, 1] = 0.5
        >>> differs(up, down).tolist()
        [False, True]
    """
    means = [np.moveaxis(np.asarray(circular_mean(lag, axis=2)), 0, -1) for lag in (up, down)]
    return distance(*means) > tolerance


def switches(omega: Sequence[float], gait: Sequence[str]) -> tuple[Switch, ...]:
    """Where the gait changes along a sweep, in the order in which the levels are given.

    Levels without a named gait, such as those in between, belong to the change.

    Args:
        omega: the levels, in the order in which they came [rad/s].
        gait: the name at each.

    Example:
        >>> switches([1.0, 2.0, 3.0, 4.0], ["walk", "walk", "in between", "trot"])
        (Switch(before='walk', after='trot', low=2.0, high=4.0),)
    """
    there = [(w, name) for w, name in zip(omega, gait, strict=True) if name not in NO_GAIT]
    return tuple(
        Switch(a, b, float(min(v, w)), float(max(v, w)))
        for (v, a), (w, b) in pairwise(there)
        if a != b
    )


def hysteresis(omega: ArrayLike, up: ArrayLike, down: ArrayLike) -> tuple[Hysteresis, ...]:
    """Between which levels gaits change on the way up and on the way down, over all starts.

    A pair of gaits is listed if starts change from the one to the other on the way up, and back on
    the way down. Of a start that changes so several times, the last time counts.

    Args:
        omega: the levels from low to high [rad/s], [levels].
        up: names on the way up, [levels, starts].
        down: names on the way down, [levels, starts]; its first row is the lowest level, too.

    Example:
        >>> up, down = np.array([["walk", "walk", "trot"], ["walk", "trot", "trot"]])
        >>> (found,) = hysteresis([1.0, 2.0, 3.0], up[:, None], down[:, None])
        >>> found.slow, found.fast, found.up, found.down, found.width
        ('walk', 'trot', (2.0, 3.0), (1.0, 2.0), (0.0, 2.0))
    """
    levels = np.asarray(omega, float)
    rising = _last_switches(levels, np.asarray(up))
    back = _last_switches(levels[::-1], np.asarray(down)[::-1])
    falling = {(slow, fast): found for (fast, slow), found in back.items()}
    found = []
    for pair in rising:
        if pair not in falling:
            continue
        up_at, down_at = _between(rising[pair]), _between(falling[pair])
        width = (up_at[0] - down_at[1], up_at[1] - down_at[0])
        starts = len(rising[pair]), len(falling[pair])
        found.append(Hysteresis(*pair, up_at, down_at, width, *starts))
    return tuple(found)


def _last_switches(levels: np.ndarray, gait: np.ndarray) -> dict[tuple[str, str], list[Switch]]:
    """How each start changes for the last time between each pair of gaits."""
    found: dict[tuple[str, str], list[Switch]] = {}
    for column in gait.T:
        last = {(s.before, s.after): s for s in switches(levels.tolist(), column.tolist())}
        for pair, switch in last.items():
            found.setdefault(pair, []).append(switch)
    return found


def _between(switches: Sequence[Switch]) -> tuple[float, float]:
    """The levels between which all of them lie [rad/s]."""
    return min(each.low for each in switches), max(each.high for each in switches)
