"""Making the kept table of the default hopper anew."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context

import numpy as np

from research.reproduction.optimum.best import STANCES
from research.reproduction.optimum.proofs import DIGITS, write_bounds
from research.reproduction.optimum.trajectory import highest_frequency, optimise
from tegotae._support.errors import TegotaeError, require, require_count, require_finite
from tegotae._support.progress import reporting
from tegotae._support.tables import write_csv
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper

_SLOW = (1.0, 1.5, 2.0, 2.5, 2.75)  # rad/s
_PEAK = (3.1, 3.15, 3.2)  # rad/s, where the leg's length begins to matter
_STANCES = (4.0, 8.0)  # rad/s


@dataclass(frozen=True)
class Make:
    """Make the table of the optimum anew: gaits of the default hopper, bounds and their proofs."""

    step: float = 0.25
    """Step of the frequencies from 3 to 10 rad/s; others are wider [rad/s]."""
    starts: int = 4
    """Random starts per shape of gait."""
    processes: int = 2
    """Number of frequencies computed at once."""

    def run(self) -> None:
        """Optimise, bound, write."""
        require_finite("step", self.step, above=0.0)
        require_count("starts", self.starts)
        require_count("processes", self.processes)
        require("casadi", "optimum")
        # The fastest hop leaves no choice: the last row stands a little below it.
        fastest = 0.995 * highest_frequency(Hopper())
        middle = np.arange(3.0, 10.0 + 1e-9, self.step)
        omegas = np.sort(np.concatenate([_SLOW, _PEAK, middle, np.geomspace(11.0, fastest, 12)]))
        context = get_context("spawn")
        with (
            reporting("optimum", len(omegas)) as reporter,
            ProcessPoolExecutor(self.processes, context) as pool,
        ):
            rows = []
            for row in pool.map(partial(_row, self.starts), omegas.tolist()):
                rows.append(row)
                reporter.update(len(rows), f"{row['omega']:.2f} rad/s")
        table = {
            name: np.array(column) for name, column in _columns(list(curve().columns), rows).items()
        }
        write_bounds(table)
        names = ["omega", "time_s", "height_m", "velocity_m_per_s", "force_n"]
        stances = _columns(names, _stance_rows(names, self.starts))
        write_csv(STANCES, stances, digits=DIGITS)


def _row(starts: int, omega: float) -> dict[str, float]:
    """Compute one frequency of the table."""
    body = Hopper()
    row = {"omega": omega}
    try:
        gait = optimise(body, omega, starts=starts)
    except TegotaeError:
        pass
    else:
        flight_s = 2.0 * gait.lift_off_m_per_s.max() / body.gravity_m_per_s2
        row |= {
            "cot_inverse": gait.cot_inverse,
            "lift_off": gait.lift_off_m_per_s.max(),
            "stance_s": 2.0 * math.pi / gait.omega - flight_s,
            "swings": sum(stance.swings for stance in gait.shape),
            "bounces": sum(stance.bounce for stance in gait.shape),
            "converged": gait.converged,
        }
    try:
        two = optimise(body, omega, period=2, starts=4 * starts)
    except TegotaeError:
        pass
    else:
        speeds = sorted(
            speed
            for speed, stance in zip(two.lift_off_m_per_s, two.shape, strict=True)
            if not stance.bounce
        )
        row |= {
            "cot_inverse_two": two.cot_inverse,
            "lift_off_low": speeds[0],
            "lift_off_high": speeds[-1],
        }
    return row


def _stance_rows(names: list[str], starts: int) -> list[dict[str, float]]:
    rows = []
    for omega in _STANCES:
        gait = optimise(Hopper(), omega, starts=starts)
        # A stance that ends in a hop, with all that lies between the hops before it.
        start_s = 0.0
        for parts in zip(
            gait.time_s, gait.height_m, gait.velocity_m_per_s, gait.force_n, strict=True
        ):
            time_s, *series = parts
            for values in zip(time_s + start_s, *series, strict=True):
                rows.append(dict(zip(names, (omega, *map(float, values)), strict=True)))
            start_s += time_s[-1] + 2.0 * series[1][-1] / Hopper().gravity_m_per_s2
    return rows


def _columns(names: list[str], rows: list[dict[str, float]]) -> dict[str, list[float]]:
    return {name: [row.get(name, math.nan) for row in rows] for name in names}
