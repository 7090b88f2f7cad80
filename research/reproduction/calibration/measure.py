"""Measurement of V under one reading: maps over gain and frequency, and an evaluation."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from research.reproduction.calibration.scores import (
    VanillaScores,
    quick_loss,
    reflex_stays,
    sector_line,
    slows,
    transient_score,
    tuned_gain,
)
from research.reproduction.readings.readings import Reading
from tegotae.analysis.maps import Outcome, OutcomeSummary, as_maps, lanes
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.metrics import FAILED
from tegotae.measures.objectives.fitness import EPISODE, Fitness, HopOutcome
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe

ACTUATIONS = ("sector", "reflex")
_PUSHES = ("feedback_rad_per_s", "actuator_force_n")
_FITNESS = Fitness()


@dataclass(frozen=True, kw_only=True)
class CalibrationGrid:
    """Resolution of the measurement of a reading.

    Args:
        gains: gains of the map, σ m g [rad/s].
        omegas: its frequencies [rad/s]; those of V's evaluation are among them.
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


COARSE = CalibrationGrid(
    gains=tuple(np.linspace(0.1, 12.0, 16).tolist()),
    omegas=tuple(np.linspace(2.0, 10.0, 17).tolist()),
    timing=EPISODE,
)
"""A sixth of the map's points: enough to see which readings are worth a finer look."""


class FitnessMap(NamedTuple):
    """Outcomes of one actuation over gain and frequency, [gains, frequencies]."""

    sigma: np.ndarray
    """Gains σ [rad/(s N)], [gains]."""
    omega: np.ndarray
    """Frequencies ω [rad/s], [frequencies]."""
    outcome: Outcome
    """Outcome of each rollout."""
    fitness: np.ndarray
    """Fitness that a search of V's gain maximises [m/J]."""


def vanilla_controller(reading: Reading, actuation: str) -> Controller:
    """Return the vanilla controller under a reading."""
    controller = recipe(f"V-{actuation}-w8").controller()
    return dataclasses.replace(controller, actuation=reading.actuation(controller.actuation))


def measure_reading(reading: Reading, grid: CalibrationGrid | None = None) -> VanillaScores:
    """Measure the scores of a reading.

    Bodies are data of the compiled programs: readings that share sector and work share these.

    Args:
        reading: the body, release, sector, work, and how V's gain is tuned.
        grid: how finely is looked.
    """
    grid = grid or CalibrationGrid()
    maps = {name: gain_map(reading, name, grid) for name in ACTUATIONS}
    gains = {
        (name, omega_t): tuned_gain(
            swept.sigma, swept.omega, swept.fitness, [omega_t + off for off in reading.tuned_over]
        )
        for name, swept in maps.items()
        for omega_t in grid.omega_t
    }
    return score_maps(reading, maps, gains, grid.protocol)


def score_maps(
    reading: Reading,
    maps: dict[str, FitnessMap],
    gains: dict[tuple[str, float], float],
    protocol: Protocol,
) -> VanillaScores:
    """Return the scores of a reading from its maps, with V's gains by actuation and ω_t.

    Args:
        reading: the reading.
        maps: by actuation.
        gains: of V [rad/(s N)], by actuation and ω_t.
        protocol: of V's evaluation; height and drop are the reading's.
    """
    cot = {name: np.asarray(result.outcome.cot_inverse) for name, result in maps.items()}
    length = reading.hopper.rest_length_m
    protocol = dataclasses.replace(
        protocol,
        release_m=reading.release * length,
        drop_m=reading.drop * length,
        work=reading.work,
    )
    rows = [
        _evaluated(reading, name, gain, omega_t, protocol)
        for (name, omega_t), gain in gains.items()
    ]
    settles, t0, t1, dependent, slow = np.nanmean(np.array(rows), axis=0)
    sector, reflex = maps["sector"], maps["reflex"]
    losses = [quick_loss(maps[name].omega, result) for name, result in cot.items()]
    return VanillaScores(
        settles=float(settles),
        short_t0=float(t0),
        short_t1=float(t1),
        dependent=float(dependent),
        slows=float(slow),
        sector_line=sector_line(sector.sigma, sector.omega, cot["sector"]),
        reflex_stays=reflex_stays(reflex.omega, cot["reflex"]),
        quick_loss=float(np.mean(np.nan_to_num(losses))),
    )


def gain_map(reading: Reading, actuation: str, grid: CalibrationGrid) -> FitnessMap:
    """Return the map of one actuation under a reading."""
    hopper = reading.hopper
    sigma, omega = np.array(grid.gains) / hopper.weight_n, np.array(grid.omegas)
    rollout = Rollout(
        controller=vanilla_controller(reading, actuation),
        timing=grid.timing,
        summary=_MapSummary(OutcomeSummary(GaitSummary(work=reading.work))),
    )
    gains, frequencies = lanes(sigma, omega)
    scenario = Scenario(omega=frequencies, height_m=reading.release * hopper.rest_length_m)
    outcome, hops = rollout.run(gains[:, None], scenario, hopper)
    fitness = Fitness(work=reading.work, frequency_weight=reading.frequency_weight)
    value = np.asarray(fitness.score(hops, fitness.data)["fitness"])
    return FitnessMap(
        sigma,
        omega,
        as_maps(outcome, sigma, omega),
        np.where(np.asarray(outcome.regime) == FAILED, -np.inf, value).reshape(
            len(sigma), len(omega)
        ),
    )


@dataclass(frozen=True)
class _MapSummary:
    """The outcome of a rollout and the terms of its fitness, as a `Rollout`'s summary."""

    outcome: OutcomeSummary

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[Outcome, HopOutcome]:
        arguments = trajectory, scenario, body, timing
        return self.outcome(*arguments), _FITNESS.outcome(*arguments)


def _evaluated(
    reading: Reading, actuation: str, gain: float, omega_t: float, protocol: Protocol
) -> tuple[float, ...]:
    """Evaluate V: settled share, short T0, short T1, CPGu, slowing."""
    evaluation = evaluate(
        vanilla_controller(reading, actuation),
        [[gain]],
        omega_t,
        reading.hopper,
        protocol,
        metrics=("limit_cycle_share", "t0_s", "t1_s", "cpgu"),
        recorded=_PUSHES,
    )
    values = {name: episodes[0] for name, episodes in evaluation.episodes.items()}
    half = evaluation.recording[_PUSHES[0]].shape[0] // 2  # the later half, mostly settled
    feedback, force = (evaluation.recording[name][half:, 0] for name in _PUSHES)
    return (
        float(values["limit_cycle_share"].mean()),
        transient_score(values["t0_s"], protocol.undisturbed_s),
        transient_score(values["t1_s"], protocol.disturbed_s),
        float(np.nanmean(values["cpgu"])) if np.isfinite(values["cpgu"]).any() else np.nan,
        slows(feedback, force, evaluation.omega),
    )
