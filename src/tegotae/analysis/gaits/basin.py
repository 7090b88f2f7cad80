"""Basins of gaits: the gaits that emerge from random phases, how often, and how soon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.limits import MOST_SEEDS
from tegotae.measures.gaits.lags import circular_mean, circular_spread
from tegotae.measures.gaits.names import TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination
from tegotae.measures.hopping.statistics import wilson
from tegotae.simulation.rollout import Timing
from tegotae.systems.legged import Legged, lanes_of, random_phases


@dataclass(frozen=True)
class GaitBasin:
    """What random releases lead to."""

    legged: Legged
    """The released system."""
    phase_rad: np.ndarray
    """Phases at release [rad], [limbs, starts]."""
    found: Coordination
    """How the legs go together in the end."""
    gait: np.ndarray
    """The name of every start's gait, or why it has none, [starts]."""

    @property
    def outcomes(self) -> tuple[GaitShare, ...]:
        """The gaits that emerged, the most common first."""
        return outcomes(self.found, self.gait)


@dataclass(frozen=True)
class GaitShare:
    """One of the things that starts lead to."""

    gait: str
    """Its name, or why it has none."""
    count: int
    """How many starts end in it."""
    share: float
    """Their share."""
    low: float
    """Lower end of the share's 95 % interval (Wilson)."""
    high: float
    """Upper end."""
    lag: tuple[float, ...]
    """Circular mean of the lags over these starts, a leg [cycles]."""
    between: tuple[float, ...]
    """And their circular standard deviation, a leg [cycles]: near zero if the starts end in one
    gait and not merely in gaits of one name."""
    lock_time_s: float
    """Median time to lock [s]; NaN without."""


def find_basin(
    legged: Legged,
    starts: int = 256,
    *,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
    window_s: float | None = None,
) -> GaitBasin:
    """Release a body at random phases of its legs, and count the emerging gaits.

    Args:
        legged: the body and what drives it.
        starts: how many releases; their phases are independent, and even on the circle.
        seed: of the phases; more starts of a seed begin with the same ones.
        tolerance: how far lags may be from a named pattern's [cycles].
        timing: of each rollout; that of the system by default.
        window_s: length of its end that is measured [s]; its last quarter by default.

    Raises:
        TegotaeError: for numbers out of their range, a controller without an oscillator, whose
            releases would all be the same one, or what the engine refuses.

    Example:
        >>> from tegotae.analysis.gaits import system
        >>> [(each.gait, each.share) for each in find_basin(system("bar-light"), 8).outcomes]
        [('antiphase', 1.0)]
    """
    require_count("starts", starts, most=MOST_SEEDS)
    if legged.controller.oscillator is None:
        raise TegotaeError(
            "starts differ in the phases of the oscillators, and this controller has none: all "
            "would be the same one, which a simulation shows"
        )
    phase = random_phases(legged.body.limbs, starts, seed)
    summary = legged.summary(window_s=window_s)
    found = lanes_of(legged.run(summary, legged.scenario(phase), timing))
    return GaitBasin(legged, phase, found, gait_of(found, legged.names, tolerance))


def outcomes(found: Coordination, gait: np.ndarray) -> tuple[GaitShare, ...]:
    """How common each gait is, the most common first; those as common in the order of letters.

    Args:
        found: the coordination of every start.
        gait: their names, [starts].
    """
    listed = []
    for name in np.unique(gait):
        own = gait == name
        lag = np.asarray(found.lag)[:, own]
        times = np.asarray(found.lock_time_s)[own]
        low, high = wilson(int(own.sum()), len(gait))
        listed.append(
            GaitShare(
                gait=str(name),
                count=int(own.sum()),
                share=float(own.mean()),
                low=low,
                high=high,
                lag=tuple(np.asarray(circular_mean(lag, axis=1), float).tolist()),
                between=tuple(np.asarray(circular_spread(lag, axis=1), float).tolist()),
                lock_time_s=float(np.nanmedian(times)) if np.isfinite(times).any() else np.nan,
            )
        )
    return tuple(sorted(listed, key=lambda outcome: (-outcome.count, outcome.gait)))
