"""The gait of a model's best run, kept in its record: what the report draws of it.

It is what the evaluation has recorded, so that nothing is rolled out for it.
"""

from __future__ import annotations

import math

import numpy as np

from research.reproduction.record import Record
from tegotae.analysis.orbit import Orbit
from tegotae.measures.evaluation import Evaluation
from tegotae.measures.hopping.hopping import hop_height_m
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import SavedController

CHANNELS = (
    *("time_s", "height_m", "velocity_m_per_s", "ground_m", "phase_rad", "spring_force_n"),
    *("feedback_rad_per_s", "actuator_force_n"),
    *("apex_time_s", "apex_height_m", "apex_phase_rad"),
)
"""Recorded channels of the gait."""
LAST_S = 8.0
"""Longest recorded end of the undisturbed part [s]."""


def best_run(fitness: np.ndarray) -> int:
    """Return the run of highest fitness, the first of equal ones; `fitness` has shape [runs]."""
    return int(np.argmax(fitness))


def gait_channels(
    evaluation: Evaluation, fitness: np.ndarray, omega: float | None
) -> dict[str, np.ndarray]:
    """Return the best run's last seconds before the ground drops, at the training frequency.

    Args:
        evaluation: the evaluation, with these channels; its first runs are the trained ones.
        fitness: of the trained runs, shape [runs].
        omega: training frequency [rad/s]; None without an oscillator.

    Returns:
        Channels by name, shape [frames]; none if no episode is at that frequency.
    """
    episode = _episode(evaluation.omega, omega)
    if episode is None:
        return {}
    last = -round(LAST_S / Timing().frame_s)
    return {
        name: values[last:, best_run(fitness), episode].astype("float32")
        for name, values in evaluation.recording.items()
    }


def recorded_controller(record: Record, run: int) -> SavedController:
    """Return the controller of one run of a record, in the form of a file."""
    experiment = record.experiment
    return SavedController(
        experiment.system,
        np.asarray(record.weights[run], float),
        experiment.name,
        experiment,
        training={"seed": run, "best_fitness": float(record.best_fitness[run])},
        software=record.software,
    )


def recorded_orbit(record: Record) -> Orbit | None:
    """Return the kept limit cycle: its last repeats, superposed.

    Frames lie elsewhere in each cycle, so that together they show more of it than one would. None
    if the gait has no limit cycle.
    """
    gait, experiment = record.gait, record.experiment
    episode = _episode(record.omega, experiment.omega)
    assert episode is not None  # a gait is kept
    hops = record.episodes["limit_cycle_period"][best_run(record.best_fitness), episode]
    # NaN in frames without an apex compares as false.
    hop_limit_m = hop_height_m(float(np.asarray(experiment.body.rest_length_m)), gait["ground_m"])
    hop_ticks = np.flatnonzero(gait["apex_height_m"] >= hop_limit_m)
    repeats = experiment.protocol.limit_cycle.min_repeats
    if not np.isfinite(hops) or len(hop_ticks) <= hops:
        return None
    k = int(hops)
    begins = hop_ticks[::-1][::k][::-1][
        -repeats - 1 :
    ]  # of every cycle the first apex, and the end
    apex_s, time = gait["apex_time_s"], gait["time_s"]
    inside = (time > apex_s[begins[0]]) & (time <= apex_s[begins[-1]])
    cycle = np.searchsorted(apex_s[begins], time[inside]) - 1
    since = time[inside] - apex_s[begins][cycle]
    order = np.argsort(since)
    path = {name: values[inside][order] for name, values in gait.items()}
    apexes = hop_ticks[-k - 1 : -1]
    return Orbit(
        hops=k,
        period_s=float(np.mean(np.diff(apex_s[begins]))),
        apex_height_m=gait["apex_height_m"][apexes],
        apex_phase_rad=gait["apex_phase_rad"][apexes],
        time_s=since[order],
        height_m=path["height_m"],
        velocity_m_per_s=path["velocity_m_per_s"],
        phase_rad=path["phase_rad"] % math.tau,
        spring_force_n=path["spring_force_n"],
        feedback_rad_per_s=path["feedback_rad_per_s"],
        actuator_force_n=path["actuator_force_n"],
    )


def _episode(omegas: np.ndarray, omega: float | None) -> int | None:
    """Return the number of the episode at the training frequency; the only one without an
    oscillator.
    """
    matches = np.flatnonzero(np.isnan(omegas) if omega is None else omegas == omega)
    return int(matches[0]) if len(matches) else None
