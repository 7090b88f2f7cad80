"""Laws of Go1's feet that are compared, the disturbances, and the trainings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tegotae_robots.benchmark.conditions import TWELVE, RobotCondition

FOLDER = Path(__file__).parent
"""Place of the page, its tables and pictures."""
LAWS_FOLDER = FOLDER / "laws"
"""Place of the trained laws, and of the scores of their trainings."""
SECONDS = 30.0
"""Duration of an episode [s]."""
SPEEDS = (0.3, 0.6, 1.2, 1.8, 2.5)
"""Commanded speeds [m/s]."""
STARTS = (1001, 1002, 1003, 1004)
"""Seeds of starts that no training met."""
CALIBRATION = (3001, 3002)
"""Seeds of the starts from which speeds are calibrated."""
SELECTED = 8
"""Run with the fewest falls and slow episodes, and of these the cheapest, from eight other starts,
among the ten trots with balance reflexes after their first phase of training."""


UNDISTURBED, RANDOM_PHASES = "undisturbed", "random phases"
CONDITIONS = TWELVE | {RANDOM_PHASES: RobotCondition(random_phases=True)}


@dataclass(frozen=True)
class Law:
    """Row of the table.

    Args:
        senses: what it reads.
        parameters: number of trained parameters.
        stem: of its files in `LAWS_FOLDER`; empty for a law without training.
    """

    senses: str
    parameters: int
    stem: str


OPEN_LOOP = "trained open-loop trot"
BALANCED = "trot with balance reflexes"
ADAPTED = "tilt-triggered step adaptation"
PPO = "PPO on loads and an IMU"
LAWS = {
    "open-loop trot": Law("none", 0, ""),
    OPEN_LOOP: Law("none", 5, "open-loop"),
    BALANCED: Law("IMU", 9, "clock-p"),
    ADAPTED: Law("IMU", 11, "wary"),
    PPO: Law("load, IMU", 5836, "ppo"),
}
"""Laws by their names on the page."""


@dataclass(frozen=True)
class Check:
    """Evaluation of the final law under `HARD` conditions that differs from that of the table.

    Args:
        runs: seeds of the trainings.
        starts: seeds of the starts.
        seconds: duration of an episode [s].
        finer: whether the simulation's time step is half of the model's.
    """

    runs: tuple[int, ...]
    starts: tuple[int, ...] = STARTS
    seconds: float = SECONDS
    finer: bool = False


HARD = (UNDISTURBED, "push 1 m/s", "5° down", "blocks 4 cm")
"""Conditions of the checks."""
CHECKS = {
    "8 other starts": Check((SELECTED,), starts=tuple(range(2001, 2009))),
    "60 s": Check((SELECTED,), seconds=60.0),
    "half the time step": Check((SELECTED,), finer=True),
}


MET = (
    RobotCondition(push_m_per_s=1.0),
    RobotCondition(blocks_m=0.04),
    RobotCondition(random_phases=True, delay_s=0.02),
)
"""Conditions of all trainings; a push is to the left in all, and a law is mirrored."""
TRAINED_SPEEDS, TRAINED_S = (0.3, 1.3, 2.5), 8.0
"""Commanded speeds [m/s] and duration [s] of the episodes of trainings."""
POPULATION = 12
"""Candidates of a generation of CMA-ES."""
OFF_COURSE = 0.3
"""Weight of a heading error of 1 rad in the fitness."""


@dataclass(frozen=True)
class Phase:
    """Phase of a training.

    Args:
        price: weight of the cost of transport in the fitness.
        conditions: disturbances that every candidate meets.
        generations: of CMA-ES.
        std: initial standard deviation of the candidates.
        steps: total number of steps of PPO at the end: the simulated time of CMA-ES.
    """

    price: float
    conditions: tuple[RobotCondition, ...]
    generations: int
    std: float
    steps: int


PHASES = (
    Phase(0.1, MET, 25, 0.08, 2_160_000),
    Phase(0.2, (*MET, RobotCondition(blocks_m=0.02)), 15, 0.04, 3_888_000),
)
"""Phases of the trainings; the open-loop trot has the first alone."""
ADAPTATION = {"sigma": 0.025, "lift": 0.75}
"""Gain of the tilt signal, and share of the trained lift without a tilt; set by trials with other
starts, and not trained."""
