"""Does the walker walk as its equations say? Beside an adaptive solver, and a MuJoCo twin.

    python -m research.gaits.legs_validation

writes `legs_validation_ticks.csv`, `legs_validation_twin.csv` and `legs_validation.png` to
this folder. It takes about three minutes of a core, and needs the extra `mujoco`.

Lengths, times and forces are in the leg's length, √(l0/g) and the weight.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from research.benchmarks import mujoco_walker
from research.frame import main, write_rows
from tegotae import Timing
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.parts.bodies import Walker
from tegotae.parts.parameters import traceable

DOCS = Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS.parent / "tests" / "helpers"))

import walkers  # noqa: E402
from walker_oracle import SET_A, SET_C, Start, walk  # noqa: E402

OUT = Path(__file__).parent
SETS = {"A": (SET_A, (2.6,)), "C": (SET_C, (0.9, 2.1, 3.2))}
"""Bodies, and the frequencies at which they are watched."""
FRAME = 0.1
TICKS = tuple(FRAME / n for n in (4, 7, 10, 20, 40))
"""Control periods; 0.0143 are 2 ms with legs that are 0.2 m long."""
SHORT, LONG, LAST = 9.0, 60.0, 30.0
"""Time over which paths are compared, length of a walk, and length of its evaluated last part."""
PHASES = (0.3, 3.0, 3.6, 0.9)
STARTS = 4
"""Further random starts, for the twin."""


@traceable
@dataclass(frozen=True, kw_only=True)
class AnyTick(Walker):
    """A walker that accepts every tick."""

    def check_tick(self, tick_s: float) -> None:
        """Accept every tick."""


@dataclass(frozen=True)
class Gait:
    """Gait over the whole strides in the last part of a walk."""

    lags: np.ndarray
    """Lags of all legs behind the first, [legs] [cycles]."""
    speed: float
    frequency: float
    """Strides per √(l0/g)."""
    cost: float = np.nan
    """Cost of transport."""

    @classmethod
    def from_path(cls, time, place, phase, work=None) -> Gait:
        """Compute the gait from times, places [frames, 2], phases [frames, legs] and absolute work
        [frames]."""
        phase = np.unwrap(phase, axis=0)
        strides = np.maximum.accumulate(phase[:, 0]) / (2 * np.pi)
        first = np.ceil(np.interp(time[-1] - LAST, time, strides))
        ends = np.interp([first, np.floor(strides[-1])], strides, time)
        count, taken = np.floor(strides[-1]) - first, ends[1] - ends[0]
        within = (time >= ends[0]) & (time <= ends[1])
        turned = np.exp(1j * (phase[within, :1] - phase[within])).mean(0)
        distance = np.hypot(*(np.diff(np.interp(ends, time, x))[0] for x in place.T))
        cost = np.nan if work is None else np.diff(np.interp(ends, time, work))[0] / distance
        return cls(np.angle(turned) / (2 * np.pi) % 1.0, distance / taken, count / taken, cost)


def largest_lag_difference(a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest difference of lags, modulo a turn."""
    return float(np.abs((a - b + 0.5) % 1.0 - 0.5).max())


def starts() -> np.ndarray:
    """Return the phases of the first start and the random ones, [legs, starts]."""
    random = np.random.default_rng(0).uniform(0.0, 2 * np.pi, (4, STARTS))
    return np.column_stack([PHASES, random])


def engine(name: str, tick: float) -> dict[str, np.ndarray]:
    """Simulate all starts at all frequencies: channels [frames, ..., frequencies, starts]."""
    parts, omegas = SETS[name]
    phases = np.tile(starts(), len(omegas))
    timing = Timing(duration_s=LONG, tick_s=tick, frame_s=FRAME)
    path = walkers.run(parts, np.repeat(omegas, STARTS + 1), phases, timing, AnyTick)
    return {k: x.reshape(*x.shape[:-1], len(omegas), STARTS + 1) for k, x in path.items()}


def gait(path: dict[str, np.ndarray], index: int, start: int) -> Gait:
    """Return the gait of one lane of the engine."""
    lane = {name: x[..., index, start] for name, x in path.items()}
    place = np.column_stack([lane["x_m"], lane["y_m"]])
    return Gait.from_path(lane["time_s"], place, lane["phase_rad"], lane["work_absolute_j"])


def tick_rows(name: str, paths: dict[float, dict[str, np.ndarray]]) -> list[dict[str, Any]]:
    """Return the differences to the adaptive solver, of every frequency and tick."""
    parts, omegas = SETS[name]
    rows = []
    times = FRAME * np.arange(1, round(LONG / FRAME) + 1)
    for index, omega in enumerate(omegas):
        start = Start((0.0, 0.0, 1.0 + parts.com_z))
        reference = walk(parts, omega, start, PHASES, times, rtol=1e-8, atol=1e-10)
        work = (reference.work_done - reference.work_taken).sum(1)
        expected = Gait.from_path(times, reference.place[:, :2], reference.phase, work)
        early = times <= SHORT + 1e-9
        for tick, path in paths.items():
            lane = {channel: x[early][..., index, 0] for channel, x in path.items()}
            place = np.column_stack([lane["x_m"], lane["y_m"], lane["height_m"]])
            phase = np.angle(np.exp(1j * (lane["phase_rad"] - reference.phase[early])))
            result = gait(path, index, 0)
            row = {
                "set": name,
                "omega": omega,
                "tick": tick,
                "place_error": np.abs(place - reference.place[early]).max(),
                "phase_error_rad": np.abs(phase).max(),
                "load_error": np.abs(lane["spring_force_n"] - reference.load[early]).max(),
                "lag_error_cycles": largest_lag_difference(result.lags, expected.lags),
                "speed_error_share": result.speed / expected.speed - 1,
                "frequency_error_share": result.frequency / expected.frequency - 1,
                "cost_error_share": result.cost / expected.cost - 1,
                "speed": expected.speed,
                "cost_of_transport": expected.cost,
                "hind_lag": expected.lags[2],
            }
            rows.append({k: float(f"{x:.4g}") if k != "set" else x for k, x in row.items()})
    return rows


def twin_rows(name: str, path: dict[str, np.ndarray]) -> list[dict[str, Any]]:
    """Return the gaits of the twin and of the engine, from the same random starts."""
    parts, omegas = SETS[name]
    body, foot = walkers.body_of(parts), walkers.controller_of(parts).actuation
    rows = []
    for index, omega in enumerate(omegas):
        for start, phases in enumerate(starts().T[1:], 1):
            record = mujoco_walker.walk(
                body, foot, omega=omega, sigma=parts.sigma, phase_rad=phases, duration_s=LONG
            )
            twin = Gait.from_path(record.time_s, record.place_m[:, :2], record.phase_rad)
            for simulator, result in (("walker", gait(path, index, start)), ("twin", twin)):
                row = {"lag_rf": result.lags[1], "lag_lh": result.lags[2], "lag_rh": result.lags[3]}
                row |= {"speed": result.speed, "frequency": result.frequency}
                rounded = {k: round(float(x), 4) for k, x in row.items()}
                rows.append(
                    {"set": name, "omega": omega, "start": start, "who": simulator, **rounded}
                )
    return rows


def draw(ticks: list[dict[str, Any]], twins: list[dict[str, Any]], path: Path) -> None:
    """Draw errors over the tick; lag and speed of walker, twin and adaptive solver over
    frequency.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.3)
        errors, lags, speeds = figure.subplots(1, 3)
        for marker, (name, (_, omegas)) in zip("os", SETS.items(), strict=True):
            for omega in omegas:
                rows = [r for r in ticks if r["set"] == name and r["omega"] == omega]
                errors.loglog(
                    [r["tick"] for r in rows],
                    [r["phase_error_rad"] for r in rows],
                    marker=marker,
                    markersize=3,
                    label=f"{name}, ω = {omega:g}",
                )
        guide = np.array([0.003, 0.02])
        errors.loglog(guide, 20 * guide**2, color="0.6", linestyle=":", label="∝ tick²")
        errors.set_xlabel("tick [√(l0/g)]")
        errors.set_xticks(TICKS, ["0.025", "", "0.01", "0.005", "0.0025"])
        errors.minorticks_off()
        errors.set_ylabel("largest phase error [rad]")
        errors.legend()
        selection = [r for r in twins if r["set"] == "C"]
        for simulator, marker, shift in (("walker", "o", -0.03), ("twin", "x", 0.03)):
            rows = [r for r in selection if r["who"] == simulator]
            omegas = [r["omega"] + shift for r in rows]
            lags.plot(omegas, [r["lag_lh"] for r in rows], marker, markersize=4)
            speeds.plot(omegas, [r["speed"] for r in rows], marker, markersize=4, label=simulator)
        solved = [r for r in ticks if r["set"] == "C" and r["tick"] == TICKS[0]]
        for axes, key in ((lags, "hind_lag"), (speeds, "speed")):
            omegas = [r["omega"] for r in solved]
            axes.plot(omegas, [r[key] for r in solved], "k_", markersize=14, label="adaptive")
            axes.set_xlabel("ω [√(g/l0)]")
        lags.set_ylim(0.0, 0.6)
        lags.set_ylabel("lag of the left hind leg [cycles]")
        speeds.set_ylim(bottom=0.0)
        speeds.set_ylabel("speed [√(g l0)]")
        speeds.legend(title="set C")
        save_figure(figure, path)


def run() -> None:
    """Run the whole study."""
    ticks, twins = [], []
    for name in SETS:
        paths = {tick: engine(name, tick) for tick in TICKS}
        ticks += tick_rows(name, paths)
        twins += twin_rows(name, paths[FRAME / 10])
    write_rows(OUT / "legs_validation_ticks.csv", ticks, digits=4)
    write_rows(OUT / "legs_validation_twin.csv", twins, digits=4)
    draw(ticks, twins, OUT / "legs_validation.png")


if __name__ == "__main__":
    main(run)
