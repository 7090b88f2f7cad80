"""What vanilla feedback and forced gaits cost on the quadruped's ellipse, over gain and frequency.

One number, σ, was tuned at one frequency where learned feedback was compared with it. A walker's
speed follows from its frequency, so that at a given speed σ and ω may be chosen together.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from kept import write_rows, write_text
from learned_legs_plan import TABLES
from tegotae._support.tables import read_csv
from tegotae.measures.fronts import front
from tegotae.measures.gaits.names import patterns_for
from tegotae.studies.gaits.evaluation import evaluate_gaits
from tegotae.systems.legged import Legged, lanes_of
from tegotae.systems.legged_systems import system

SIGMAS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)
"""Gains that are tried [rad/(s N)]."""
OMEGAS = tuple(float(x) for x in np.arange(1.5, 3.01, 0.125))
"""Frequencies that are tried [rad/s]."""
STARTS = 8
"""Random releases of each."""
SPEEDS = (0.2, 0.25, 0.3, 0.35, 0.4)
"""Speeds at which the cheapest is looked for [√(g l0)]."""
NEAR = 0.025
"""How far from such a speed a gait may be [√(g l0)]."""
LEARNED = tuple(f"AR-rF{note}@quadruped-c" for note in ("", "+long", "+wide"))
"""The cells of AR at ω = 2."""


def sweep() -> None:
    """Write `vanilla.csv` and `forced_trot.csv`, and what they say of AR's runs.

    `vanilla.md`: the cheapest at every speed; `vanilla_shares.csv`: AR's runs, one by one.
    """
    write_rows(TABLES / "vanilla.csv", swept(), digits=4)
    write_rows(TABLES / "forced_trot.csv", forced(OMEGAS, ("trot",)), digits=4)
    write_text(TABLES / "vanilla.md", by_speed())
    write_rows(TABLES / "vanilla_shares.csv", shares(), digits=4)


def swept() -> list[dict[str, Any]]:
    """A row per gain and frequency, from random phases."""
    found = evaluate_gaits(system("quadruped-c"), np.array(SIGMAS)[:, None], OMEGAS, STARTS)
    measures = found.measures
    return [
        {
            "sigma": sigma,
            "omega": omega,
            **{name: x[run, at] for name, x in measures.items()},
            "gait": found.commonest(run, at)[0],
        }
        for run, sigma in enumerate(SIGMAS)
        for at, omega in enumerate(OMEGAS)
    ]


def forced(omegas: tuple[float, ...], only: tuple[str, ...] = ()) -> list[dict[str, Any]]:
    """The quadruped with legs that turn at ω without feedback, started in each pattern of lags.

    Args:
        omegas: frequencies ω [rad/s].
        only: names of patterns; all if none is given.
    """
    legged: Legged = system("quadruped-c")
    patterns = {p.name: p for p in patterns_for(legged.names) if not only or p.name in only}
    lags = np.array([[p.lags[leg] for p in patterns.values()] for leg in legged.names])
    phase = np.tile(-2.0 * np.pi * lags, len(omegas))
    still = dataclasses.replace(legged, weights=(0.0,))
    scenario = still.scenario(phase)._replace(omega=np.repeat(omegas, len(patterns)))
    found = lanes_of(still.run(still.summary(), scenario))
    return [
        {
            "omega": w,
            "gait": name,
            "speed_m_per_s": found.speed_m_per_s[lane],
            "cost_of_transport": found.cost_of_transport[lane],
            "froude": found.froude[lane],
            "fall_time_s": found.fall_time_s[lane],
        }
        for lane, (w, name) in enumerate((w, name) for w in omegas for name in patterns)
    ]


class Cheapest:
    """The cheapest vanilla gait and forced trot near a speed, from the kept tables."""

    def __init__(self) -> None:
        free, tied = read_csv(TABLES / "vanilla.csv"), read_csv(TABLES / "forced_trot.csv")
        self.speed, cost, up, lock = (numbers(free, name) for name in _MEASURES)
        self.cost = np.where((up == 1.0) & (lock >= 0.5), cost, np.nan)
        self.trot_speed, self.trot_cost = (numbers(tied, name) for name in _MEASURES[:2])
        self.free, self.tied = free, tied

    def vanilla(self, speed: float) -> tuple[float, str]:
        """Its cost, and its σ, ω and gait."""
        cost, k = _least(np.where(np.abs(self.speed - speed) <= NEAR, self.cost, np.nan))
        return cost, ", ".join(str(self.free[name][k]) for name in ("sigma", "omega", "gait"))

    def trot(self, speed: float) -> tuple[float, str]:
        """Its cost, and its ω."""
        cost, k = _least(np.where(np.abs(self.trot_speed - speed) <= NEAR, self.trot_cost, np.nan))
        return cost, str(self.tied["omega"][k])


def by_speed() -> str:
    """The cheapest at every speed, and AR's runs there, as a table."""
    found, (speed, cost) = Cheapest(), learned()[1:]
    lines = ["| speed | vanilla | σ, ω, gait | forced trot | ω | AR |", "|---" * 6 + "|"]
    for at in SPEEDS:
        cells = [f"{at:g} ± {NEAR:g}"]
        for least, how in (found.vanilla(at), found.trot(at)):
            cells += [f"{least:.2f}", how] if np.isfinite(least) else ["–", "–"]
        there = np.sort(cost[np.abs(speed - at) <= NEAR])
        cells.append(", ".join(f"{x:.2f}" for x in there) or "–")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def shares() -> list[dict[str, Any]]:
    """A row per run of AR: its cost over that of the cheapest vanilla gait near its speed.

    On the same ellipse, and over the fronts, whose ellipses are tuned for every speed.
    """
    found = Cheapest()
    fronts = {name: front("quadruped-c", name) for name in ("vanilla", "forced trot")}
    rows = []
    for name, speed, cost in zip(*learned(), strict=True):
        least, _ = found.vanilla(speed)
        row = {"run": name, "speed_m_per_s": speed, "cost_of_transport": cost}
        row |= {"vanilla": least, "share": cost / least}
        for name, own in fronts.items():
            at = float(own.cost_at(speed))
            row |= {f"{name} front": at, f"share of {name} front": cost / at}
        rows.append(row)
    return rows


def learned() -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names, speeds and costs of AR's runs at ω = 2, by either search and trained longer."""
    table = read_csv(TABLES / "judged.csv")
    mine = np.isin([str(cell) for cell in table["cell"]], LEARNED)
    names = [f"{c} {r}" for c, r, own in zip(table["cell"], table["run"], mine, strict=True) if own]
    speed, cost = (numbers(table, name)[mine] for name in _MEASURES[:2])
    return names, speed, cost


_MEASURES = ("speed_m_per_s", "cost_of_transport", "upright", "locked")


def numbers(table: Any, name: str) -> np.ndarray:
    """A column as numbers; NaN where it is empty."""
    return np.array([float(cell) if str(cell) else np.nan for cell in table[name]])


def _least(cost: np.ndarray) -> tuple[float, int]:
    """The least of what is defined, and where; NaN if nothing is."""
    if np.isnan(cost).all():
        return np.nan, 0
    k = int(np.nanargmin(cost))
    return float(cost[k]), k
