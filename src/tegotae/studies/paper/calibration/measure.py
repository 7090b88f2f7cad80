"""The scores of one reading: maps over gain and frequency, and an evaluation of V."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.parts.controller import Controller
from tegotae.simulation.rollout import Timing
from tegotae.studies.analysis.gain_sweep import GainSweep, sweep_gain
from tegotae.studies.paper.calibration.scores import (
    VanillaScores,
    quick_loss,
    reflex_stays,
    robust_gain,
    sector_line,
    short,
    slows,
)
from tegotae.studies.paper.multiverse.readings import Reading
from tegotae.systems.models import find

ACTUATIONS = ("sector", "reflex")
_PUSHES = ("feedback_rad_per_s", "actuator_force_n")


@dataclass(frozen=True, kw_only=True)
class CalibrationGrid:
    """How finely a reading is looked at.

    Args:
        gains: gains of the map, σ m g [rad/s].
        omegas: its frequencies [rad/s].
        omega_t: frequencies at which V is evaluated, each with its own gain [rad/s].
        timing: of the map's rollouts.
        protocol: of V's evaluation; height and drop are the reading's.
    """

    gains: tuple[float, ...] = tuple(np.linspace(0.1, 12.0, 48).tolist())
    omegas: tuple[float, ...] = tuple(np.linspace(2.0, 10.0, 33).tolist())
    omega_t: tuple[float, ...] = (4.0, 8.0)
    timing: Timing = dataclasses.field(
        default_factory=lambda: Timing(duration_s=40.0, tick_s=0.002)
    )
    protocol: Protocol = dataclasses.field(
        default_factory=lambda: Protocol(undisturbed_s=30.0, disturbed_s=20.0, tick_s=0.002)
    )


def vanilla(reading: Reading, actuation: str) -> Controller:
    """The vanilla controller under a reading."""
    own = find(f"V-{actuation}-w8").controller()
    return dataclasses.replace(own, actuation=reading.actuation(own.actuation))


def measure(reading: Reading, grid: CalibrationGrid | None = None) -> VanillaScores:
    """The scores of a reading.

    Bodies are data of the compiled programs: readings that share sector and work share these.

    Args:
        reading: the body, release, sector and work.
        grid: how finely is looked.
    """
    grid = grid or CalibrationGrid()
    maps = {name: _map(reading, name, grid) for name in ACTUATIONS}
    cot = {name: np.asarray(each.outcome.cot_inverse) for name, each in maps.items()}
    omega = np.array(grid.omegas)
    protocol = dataclasses.replace(
        grid.protocol,
        release_m=reading.release * reading.hopper.rest_length_m,
        drop_m=reading.drop * reading.hopper.rest_length_m,
        work=reading.work,
    )
    found = []
    for name, each in maps.items():
        for omega_t in grid.omega_t:
            gain = robust_gain(each.sigma, omega, cot[name], omega_t)
            found.append(_evaluated(reading, name, gain, omega_t, protocol))
    own = np.array(found)
    settles, t0, t1, dependent, slow = np.nanmean(own, axis=0) if len(own) else [np.nan] * 5
    return VanillaScores(
        settles=float(settles),
        short_t0=float(t0),
        short_t1=float(t1),
        dependent=float(dependent),
        slows=float(slow),
        sector_line=sector_line(maps["sector"].sigma, omega, cot["sector"]),
        reflex_stays=reflex_stays(omega, cot["reflex"]),
        quick_loss=float(np.nanmean([quick_loss(omega, each) for each in cot.values()])),
    )


def _map(reading: Reading, actuation: str, grid: CalibrationGrid) -> GainSweep:
    hopper = reading.hopper
    return sweep_gain(
        vanilla(reading, actuation),
        np.array(grid.gains) / hopper.weight_n,
        np.array(grid.omegas),
        hopper,
        timing=grid.timing,
        work=reading.work,
        height_m=reading.release * hopper.rest_length_m,
    )


def _evaluated(
    reading: Reading, actuation: str, gain: float, omega_t: float, protocol: Protocol
) -> tuple[float, ...]:
    """What V does: settles, short T0, short T1, CPGu, slows."""
    found = evaluate(
        vanilla(reading, actuation),
        [[gain]],
        omega_t,
        reading.hopper,
        protocol,
        metrics=("limit_cycle_share", "t0_s", "t1_s", "cpgu"),
        recorded=_PUSHES,
    )
    values = {name: each[0] for name, each in found.episodes.items()}
    half = found.recording[_PUSHES[0]].shape[0] // 2  # the later half, mostly settled
    feedback, force = (found.recording[name][half:, 0] for name in _PUSHES)
    return (
        float(values["limit_cycle_share"].mean()),
        short(values["t0_s"], protocol.undisturbed_s),
        short(values["t1_s"], protocol.disturbed_s),
        float(np.nanmean(values["cpgu"])) if np.isfinite(values["cpgu"]).any() else np.nan,
        slows(feedback, force, found.omega),
    )
