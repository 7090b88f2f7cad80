"""Sweeps of the frequency: slowly up a staircase and down another, and where the gait changes.

What differs between the way up and the way down is hysteresis: at such frequencies there are two
gaits, and which one it is depends on where the body comes from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_POINTS, MOST_RAD_PER_S
from tegotae.analysis.gaits.releases import coordination_frame, gait_counts
from tegotae.measures.gaits.lags import circular_mean, drift, moved_until, rounding
from tegotae.measures.gaits.names import NO_GAIT, TOLERANCE, distance
from tegotae.measures.gaits.summary import (
    LEAST_FRAMES,
    Coordination,
    CoordinationSummary,
    coordination,
)
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.schedules import Staircase
from tegotae.systems.legged import Legged, lanes_of, random_phases

UP, DOWN = "up", "down"
DETUNING = 1e-4
"""Relative spread of the legs' frequencies (standard deviation). Legs that are exactly in phase
stay so for ever, stable or not, unless something separates them."""
MEASURED = 0.5
"""Share of every level, its end, that is measured."""
_LEVEL = "omega_rad_per_s"


@dataclass(frozen=True)
class GaitSweep:
    """Gaits of a frequency sweep up and down."""

    legged: Legged
    """The swept system."""
    frame: pd.DataFrame
    """A row a direction, level and start, levels from the lowest frequency on: the gait and the
    coordination (`coordination_frame`)."""
    tolerance: float = TOLERANCE
    """Largest distance of lags from a named pattern's, and between the two directions [cycles]."""

    @property
    def omega(self) -> np.ndarray:
        """The levels [rad/s]."""
        return np.asarray(self.frame[_LEVEL].unique())

    @property
    def hysteresis(self) -> pd.DataFrame:
        """The changes of gait, and how far apart they are on the two ways."""
        return hysteresis(self.frame)

    @property
    def bistable(self) -> np.ndarray:
        """The levels at which the lags on the way up are others than on the way down [rad/s].

        That is where the circular means over the starts are farther apart than the tolerance,
        whatever the gaits are called.
        """
        lag = self.frame[[f"lag_cycles_{leg}" for leg in self.legged.names]].to_numpy()
        directions = lag.reshape(2, len(self.omega), -1, lag.shape[1])
        up, down = (np.asarray(circular_mean(direction, axis=1)).T for direction in directions)
        return self.omega[distance(up, down) > self.tolerance]

    @property
    def summary(self) -> pd.DataFrame:
        """Gaits at every level on both ways, with their numbers of starts, as texts."""
        texts: Any = self.frame.groupby([_LEVEL, "direction"])["gait"].agg(_listed)
        table = texts.unstack()[[UP, DOWN]].add_prefix("gaits on the way ").rename_axis(index="ω")
        return table.set_index(table.index.map("{:.4g}".format))

    @property
    def notes(self) -> list[str]:
        """The changes of gait, and the levels at which the ways differ, in sentences."""
        changes = self.hysteresis.round(9).to_dict("records")
        levels = ", ".join(f"{level:.4g}" for level in self.bistable)
        return [
            *(_CHANGE.format(**change) for change in changes),
            *([] if changes else [_NO_CHANGE]),
            f"lags differ between the two ways at {levels or 'no level'}",
        ]


def _listed(gaits: pd.Series) -> str:
    return ", ".join(f"{name} {count}" for name, count in gait_counts(gaits).items())


_CHANGE = (
    "{slow} to {fast}: up between {up_low:.3g} and {up_high:.3g} ({up_starts} starts), down "
    "between {down_low:.3g} and {down_high:.3g} ({down_starts}); hysteresis between "
    "{width_low:.3g} and {width_high:.3g}"
)
_NO_CHANGE = "no named gait changes on the way up and returns on the way down"


@dataclass(frozen=True, kw_only=True)
class LevelsSummary(CoordinationSummary):
    """A `Rollout`'s summary: the coordination at every level of a staircase, [levels, ...].

    Args:
        levels: how many levels of equal length the recording has.
    """

    levels: int

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Coordination:
        """Return the coordination of every lane at every level, in the order of the levels.

        Times count from the begin of the level. How far lags have moved counts from the release,
        beside the drift of legs that do not feel each other, and what rounding makes of it.
        """
        frames = timing.n_frames // self.levels
        split = jax.tree.map(lambda x: x.reshape(self.levels, frames, *x.shape[1:]), trajectory)
        begins = round((1.0 - MEASURED) * frames)
        coordinations = jax.vmap(
            lambda level: coordination(self, level, body, timing.frame_s, begins)
        )(split)
        begun = split.time_s[:, 0] - timing.frame_s
        lag = self.rhythm.lag(trajectory, self.reference)
        omega = jnp.broadcast_to(scenario.omega, lag.shape[1:])
        own_way = drift(omega, trajectory.time_s, self.reference)
        rounded = rounding(trajectory.time_s / timing.tick_s)
        ever = moved_until(lag - own_way, rounded)[frames - 1 :: frames]
        return coordinations._replace(
            lock_time_s=coordinations.lock_time_s - begun,
            fall_time_s=coordinations.fall_time_s - begun,
            moved=jnp.where(jnp.isnan(coordinations.moved), jnp.nan, ever),
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
        >>> from tegotae.systems.resolve import legged_system as system
        >>> found = sweep(system("bar-light"), [7.5, 8.0], dwell_s=40.0, starts=2)
        >>> set(found.frame.gait)
        {'antiphase'}
    """
    if legged.omega is None:
        raise TegotaeError("the controller has no oscillator, and so no frequency to sweep")
    levels = np.asarray(omega, float)
    require_count("levels", levels.size, least=2, most=MOST_POINTS)
    for level in levels:
        require_finite("a level of omega", level, above=0.0, most=MOST_RAD_PER_S)
    steps = np.diff(levels)
    if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * levels[-1]:
        raise TegotaeError(
            f"the levels of omega are {levels.tolist()}; they must rise by equal steps"
        )
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
    summary = legged.summary(LevelsSummary, levels=len(levels))
    summaries = lanes_of(legged.run(summary, scenario, timing))
    frame = coordination_frame(  # level by level, on the way up and on the way down
        Coordination(*(np.moveaxis(x, 0, -2).reshape(*x.shape[1:-1], -1) for x in summaries)),
        legged.names,
        tolerance,
        direction=np.tile(np.where(up, UP, DOWN), len(levels)),
        omega_rad_per_s=np.where(up, levels[:, None], levels[::-1, None]).ravel(),
        start=np.tile(np.arange(starts), 2 * len(levels)),
    )
    order = ["direction", _LEVEL, "start"]
    frame = frame.sort_values(order, ascending=[False, True, True], ignore_index=True)
    return GaitSweep(legged, frame, tolerance)


def staircase_timing(timing: Timing, levels: int, dwell_s: float) -> Timing:
    """Return the timing of a staircase whose levels are whole frames.

    Raises:
        TegotaeError: for a level shorter than eight frames, or a run that is too long.
    """
    require_finite("dwell_s", dwell_s, above=0.0)
    frames = round(dwell_s / timing.frame_s)
    if frames < LEAST_FRAMES:
        raise TegotaeError(
            f"dwell_s is {dwell_s:g}; it must be at least eight frames "
            f"({LEAST_FRAMES * timing.frame_s:g} s)"
        )
    return Timing(
        duration_s=levels * frames * timing.frame_s, tick_s=timing.tick_s, frame_s=timing.frame_s
    )


def hysteresis(frame: Any) -> pd.DataFrame:
    """Return the levels between which gaits change on the way up and on the way down, over all
    starts.

    A pair of gaits is listed if starts change from the one to the other on the way up, and back on
    the way down. Of a start that changes so several times, the last time counts. Levels without a
    named gait, such as those in between, belong to the change.

    Args:
        frame: `direction`, `omega_rad_per_s`, `start` and `gait`.

    Returns:
        A row a pair `slow` and `fast`. The slow gait gives way between `up_low`, the lowest level
        at which a start that changes was last seen in it, and `up_high`, the highest at which one
        was first seen in the other; the fast one likewise on the way down; up - down lies between
        `width_low` and `width_high`. How many starts change is `up_starts` and `down_starts`.

    Example:
        >>> up = pd.DataFrame({"omega_rad_per_s": [1.0, 2.0, 3.0], "start": 0, "direction": "up"})
        >>> frame = pd.concat([up, up.assign(direction="down")])
        >>> frame["gait"] = ["walk", "walk", "trot", "walk", "trot", "trot"]
        >>> hysteresis(frame)[["slow", "up_low", "up_high", "width_high"]].values.tolist()
        [['walk', 2.0, 3.0, 2.0]]
    """
    pairs = [
        _changes(
            frame[frame.direction == direction],
            direction,
            ["slow", "fast"][:: 1 if direction == UP else -1],
        )
        for direction in (UP, DOWN)
    ]
    merged = pairs[0].merge(pairs[1], on=["slow", "fast"])
    return merged.assign(
        width_low=merged.up_low - merged.down_high, width_high=merged.up_high - merged.down_low
    )


def _changes(frame: Any, direction: str, names: list[str]) -> pd.DataFrame:
    """Return the levels between which starts change for the last time from one gait to another,
    one way.
    """
    rows = frame[~frame.gait.isin(NO_GAIT)].sort_values(
        _LEVEL, ascending=direction == UP, kind="stable"
    )
    previous = rows.groupby("start")[["gait", _LEVEL]].shift()
    ends = pd.concat([previous[_LEVEL], rows[_LEVEL]], axis=1)
    changes: Any = pd.DataFrame(
        {
            "start": rows.start,
            names[0]: previous.gait,
            names[1]: rows.gait,
            "low": ends.min(axis=1),
            "high": ends.max(axis=1),
        }
    )[previous.gait.notna() & (previous.gait != rows.gait)]
    last = changes.drop_duplicates(["start", *names], keep="last")
    return last.groupby(names, as_index=False, sort=False).agg(
        **{f"{direction}_low": ("low", "min"), f"{direction}_high": ("high", "max")},
        **{f"{direction}_starts": ("start", "size")},
    )
