"""Fronts: the least cost of transport over speed of walkers of one family.

A search that keeps the cheapest walkers of every speed: random ones first, then variations of the
cheapest so far at every speed. The cheapest of all are released once more, longer, from phases that
the search has not seen, and only these releases count.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd

from tegotae._support.documents import Document, as_json
from tegotae.analysis.gaits.releases import coordination_frame
from tegotae.measures.fronts import COLUMNS
from tegotae.measures.gaits.metrics import Walks, over_starts
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.measures.gaits.summary import length
from tegotae.measures.statistics import mean_defined
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.parts.fields import replace, unwrapped
from tegotae.parts.parameters import Part, whole
from tegotae.simulation.recorder import Trajectory, needing
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.summaries import Summary, Together
from tegotae.study import Arrays, Cell, CellResult, Study, measured_in_turn
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged, lanes_of
from tegotae.systems.tuned import NUMBERS, FrontFamily, Numbers

_SPEED_STEP = 0.05
"""Width of the bins of speed, of each of which the cheapest is kept [√(g l0)]."""
_LEAST_SPEED = 0.025
"""Below this speed a walker stands [√(g l0)]."""
_MOST_SPEED = 2.0
"""No faster walker is looked for [√(g l0)]."""
STEADY = 0.05
"""Largest change of the speed between the last two quarters, as a share of it, beside
`_STEADY_SPEED`."""
_STEADY_SPEED = 0.005
"""Speed that is within what parts of a stride change [√(g l0)]."""
_PARENTS = 6
"""Walkers of every bin that are varied."""
_FINALISTS = 8
"""Walkers of every bin that are released from unseen phases."""
UNSEEN = 1_000
"""Added to the seed for the phases of the finalists."""
LANES = 8192
"""Approximate number of lanes that the search advances at once."""
_COARSE_TICKS = 125
"""Ticks of a frame of the search."""

SUFFIX = ".front.npz"
"""Suffix of the files of a search."""
_MOST = 1_000_000
"""Limit of walkers, variations, rounds and releases: some hundred of them take a second."""


@dataclass(frozen=True, kw_only=True)
class Search(Part):
    """Size of a search.

    Args:
        coarse: random walkers to begin with.
        rounds: how often the cheapest are varied.
        varied: how many variations a round has.
        starts: releases of each walker of the search.
        unseen: releases of each finalist.
        seed: of all draws.
        duration_s: of a release in the search; the finalists' is the system's own.

    Raises:
        TegotaeError: for a number below one, or above a million.
    """

    coarse: int = whole(16384, most=_MOST)
    rounds: int = whole(8, least=0, most=_MOST)
    varied: int = whole(1024, most=_MOST)
    starts: int = whole(4, most=_MOST)
    unseen: int = whole(32, most=_MOST)
    seed: int = 0
    duration_s: float = 100.0

    @property
    def sizes(self) -> list[int]:
        """Walkers that are advanced together: random ones, then those of every round."""
        at_once = max(1, LANES // self.starts)
        begun = range(0, self.coarse, at_once)
        coarse = [min(at_once, self.coarse - count) for count in begun]
        return coarse + [self.varied] * self.rounds


class Travel(NamedTuple):
    """Final motion of the lanes, [lanes] each."""

    speed_m_per_s: AnyArray
    """Speed over ground in the last quarter [m/s]."""
    before_m_per_s: AnyArray
    """And in the quarter before [m/s]."""
    power_w: AnyArray
    """Mean of the actuators' |power| in the last quarter [W]."""
    failed: AnyArray
    """True if the lane fell."""


@needing("time_s", "x_m", "y_m", "work_absolute_j", "failed")
def travel(trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing) -> Travel:
    """Return the `Travel` of every lane from few frames: the summary of a `Rollout`."""
    t, last = trajectory, len(trajectory.time_s) - 1
    third, half = last - last // 4, last - 2 * (last // 4)

    def speed(first: int, end: int) -> jax.Array:
        distance = length(
            [t.channels[name][end] - t.channels[name][first] for name in ("x_m", "y_m")]
        )
        return distance / (t.time_s[end] - t.time_s[first])

    work = t.work_absolute_j[last] - t.work_absolute_j[third]
    return Travel(
        speed_m_per_s=speed(third, last),
        before_m_per_s=speed(half, third),
        power_w=work / (t.time_s[last] - t.time_s[third]),
        failed=jnp.asarray(t.failed[last]),
    )


@dataclass(frozen=True)
class FrontPart(Cell):
    """Some walkers of a search, advanced together: the unit that a search keeps.

    Args:
        legged: the system.
        family: what drives its legs, and which numbers are free.
        search: how much is searched.
        number: of the part: random walkers first, then rounds of variations of the earlier parts'.
        folder: keeps the results of all parts.
    """

    legged: Legged
    family: FrontFamily
    search: Search
    number: int
    folder: Path

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name.replace(" ", "-")

    @property
    def document(self) -> Document:
        """The system, the family, the search, and which part of it."""
        settings = {"family": self.family, "search": self.search, "part": self.number}
        return {**describe(self.legged), **as_json(settings)}

    def measure(self) -> CellResult:
        """Release walkers from all phases: their `shares` of the ranges, and their speed and cost,
        NaN if they fail."""
        legged, family, search = self.legged, self.family, self.search
        shares = self._shares()
        phase = family.phases(legged, search.starts, search.seed)
        tick = legged.timing.tick_s
        timing = Timing(duration_s=search.duration_s, tick_s=tick, frame_s=_COARSE_TICKS * tick)
        numbers = family.numbers(legged, family.free(shares))
        final: Travel = _run(legged, family, numbers, phase, travel, timing)
        speed, cost = travelled(legged, final, search.starts)
        return CellResult(self.document, {}, {"shares": shares, "speed": speed, "cost": cost})

    def _shares(self) -> np.ndarray:
        """Return the positions of the free numbers in their ranges, [walkers, numbers]."""
        draw = np.random.default_rng([self.search.seed, self.number])
        sizes = self.search.sizes
        count, round_number = sizes[self.number], self.number - len(sizes) + self.search.rounds
        if round_number < 0:
            return draw.uniform(size=(count, len(self.family.ranges)))
        parts = [dataclasses.replace(self, number=n) for n in range(self.number)]
        results = Study(self.folder / "records", parts, suffix=SUFFIX).results()
        return variations(together(results), count, 0.12 * 0.75**round_number, draw)


def search_front(
    legged: Legged, family: FrontFamily, search: Search | None = None, folder: Path | None = None
) -> pd.DataFrame:
    """Search the front of a family on a legged system.

    Args:
        legged: the system.
        family: what drives its legs, and which numbers are free.
        search: how much is searched.
        folder: keeps what is done, so that interrupted work continues from there.

    Returns:
        `tegotae.measures.fronts.COLUMNS`, a row per bin of speed that some walker reaches.

    Raises:
        TegotaeError: for a system that has no such family, or a file that cannot be written.
    """
    search = search or Search()
    with TemporaryDirectory() as temporary:
        folder = folder or Path(temporary)
        parts = [FrontPart(legged, family, search, n, folder) for n in range(len(search.sizes))]
        results = measured_in_turn(parts, folder, family.name, SUFFIX)
    arrays = together(results)
    last = cheapest(arrays["speed"], arrays["cost"], _FINALISTS)
    numbers = family.numbers(legged, family.free(arrays["shares"][last]))
    rows = evaluated(legged, family, numbers, search.unseen, search.seed + UNSEEN)
    rows = rows[(rows.upright == 1.0) & (rows.steady == 1.0) & (rows.speed >= _LEAST_SPEED)]
    best = cheapest(rows.speed.to_numpy(), rows.cost_of_transport.to_numpy(), 1)
    return rows.iloc[best].reset_index(drop=True)


def travelled(legged: Legged, final: Travel, starts: int) -> tuple[np.ndarray, np.ndarray]:
    """Return mean speed and cost of transport of walkers, NaN where a start falls, stands or
    does not settle, [walkers] each.
    """
    body = unwrapped(legged.body)
    weight = float(body.mass_kg * body.gravity_m_per_s2)  # type: ignore[attr-defined]
    good = _steady_lanes(final).reshape(-1, starts).all(axis=1)
    speed = np.asarray(final.speed_m_per_s).reshape(-1, starts).mean(axis=1)
    power = np.asarray(final.power_w).reshape(-1, starts).mean(axis=1)
    good &= speed >= _LEAST_SPEED
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = power / (weight * speed)
    return np.where(good, speed, np.nan), np.where(good, cost, np.nan)


def _steady_lanes(final: Travel) -> np.ndarray:
    """Return a mask of the lanes that are upright and of steady speed, [lanes]."""
    speed, speed_before = np.asarray(final.speed_m_per_s), np.asarray(final.before_m_per_s)
    steady = np.abs(speed - speed_before) <= STEADY * np.abs(speed_before) + _STEADY_SPEED
    return steady & ~np.asarray(final.failed, bool)


def together(results: Sequence[CellResult]) -> Arrays:
    """Join all parts of a search except failed ones."""
    joined = {
        name: np.concatenate([part.arrays[name] for part in results]) for name in results[0].arrays
    }
    good = np.isfinite(joined["cost"]) & (joined["speed"] < _MOST_SPEED)
    return {name: values[good] for name, values in joined.items()}


def cheapest(speed: np.ndarray, cost: np.ndarray, count: int) -> np.ndarray:
    """Return the numbers of the cheapest walkers in every bin of speed, from the slowest bin on.

    Args:
        speed: [walkers].
        cost: [walkers].
        count: how many of every bin.

    Example:
        >>> cheapest(np.array([0.06, 0.07, 0.12]), np.array([2.0, 1.0, 3.0]), 1).tolist()
        [1, 2]
    """
    bins = np.floor(speed / _SPEED_STEP).astype(int)
    order = np.lexsort((cost, bins))
    first = np.searchsorted(bins[order], bins[order])
    return order[np.arange(len(order)) - first < count]


def variations(arrays: Arrays, count: int, width: float, draw: np.random.Generator) -> np.ndarray:
    """Return walkers near the cheapest of every speed, as shares of the ranges.

    Args:
        arrays: the walkers so far.
        count: how many.
        width: standard deviation, as a share of the range.
        draw: of the random numbers.
    """
    if not len(arrays["cost"]):
        return draw.uniform(size=(count, arrays["shares"].shape[1]))
    parents = arrays["shares"][cheapest(arrays["speed"], arrays["cost"], _PARENTS)]
    chosen_parents = parents[draw.integers(len(parents), size=count)]
    return np.clip(chosen_parents + width * draw.normal(size=chosen_parents.shape), 0.0, 1.0)


def evaluated(
    legged: Legged, family: FrontFamily, numbers: Numbers, starts: int, seed: int
) -> pd.DataFrame:
    """Release walkers at random phases, for the system's own time: a row of a front each.

    Args:
        legged: the system.
        family: what drives its legs.
        numbers: of the walkers, [walkers].
        starts: releases of each.
        seed: of their phases.
    """
    phase = family.phases(legged, starts, seed)
    summary = Together((travel, legged.summary()))
    walkers = len(numbers["omega"])
    if not walkers:
        return pd.DataFrame(columns=list(COLUMNS), dtype=float)
    own_timing = legged.timing
    timing = dataclasses.replace(own_timing, frame_s=2.0 * own_timing.frame_s)
    path, columns = _run(legged, family, numbers, phase, summary, timing)

    frame = coordination_frame(columns, legged.names, TOLERANCE)
    measured = over_starts(Walks(dict(frame), starts, legged.body))
    speeds = np.asarray(columns.speed_m_per_s).reshape(walkers, starts)
    duty = np.asarray(columns.duty_factor).mean(axis=0).reshape(walkers, starts)
    return pd.DataFrame(
        {
            **measured,
            **{name: np.asarray(numbers[name], float) for name in NUMBERS},
            "family": family.name,
            "speed": measured["speed_m_per_s"],
            "steady": _steady_lanes(path).reshape(walkers, starts).mean(axis=1),
            "speed_spread": np.nanstd(speeds, axis=1),
            "duty_factor": mean_defined(duty),
        },
        columns=list(COLUMNS),
    )


def _run(
    legged: Legged,
    family: FrontFamily,
    numbers: Mapping[str, np.ndarray],
    phase: np.ndarray,
    summary: Summary,
    timing: Timing,
) -> Any:
    starts = phase.shape[1]
    lanes = {name: np.repeat(values, starts) for name, values in numbers.items()}
    tiled = np.tile(phase, len(lanes["omega"]) // starts)
    controller = family.controller(legged)
    system = replace(legged.system, {"controller": controller})
    rollout = system.rollout(summary, timing)
    scenario = family.scenario(legged, lanes, tiled)
    return lanes_of(rollout.run(family.weights(lanes), scenario, legged.body))
