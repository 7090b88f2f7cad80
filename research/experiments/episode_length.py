"""Compare lengths of training episodes: many short ones against few long ones.

    python -m research.experiments.episode_length

writes `research/experiments/episode_length.csv` and prints it. CoT⁻¹ is meant after limit-cycle
formation, but a training episode judges what follows a fixed time. Both ways spend the same
simulated time.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import Row, main
from tegotae.measures.evaluation import evaluate
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.statistics import mean_defined
from tegotae.simulation.rollout import Timing
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping

MODELS = (
    *("VG-gF-reflex-w4", "VT-tphif-w4", "AR-rF-sector-w4", "AR-rF-reflex-w4", "ART-rF-tphif-w4"),
    *("ART-rFv-tphif-w4", "AR-rF-reflex-w8", "ART-rF-tphif-w8"),
)
WAYS = ((12, 4, 64), (24, 12, 32))
"""Episode [s], of which left to settle [s], and episodes in a generation."""
_STEPS = PGPE(std=0.3, std_lr=0.1, learning_rate=0.2, max_speed=0.4)
"""Larger than by default, as the trainings are short."""
METRICS = ("limit_cycle_share", "cot_inverse", "cot_inverse_total", "t0_s")


def run(seeds: int = 8, generations: int = 80) -> None:
    """Train, evaluate, and write the table.

    Args:
        seeds: trainings of each model.
        generations: generations of PGPE.
    """
    rows = [row(model, *way, seeds, generations) for model in MODELS for way in WAYS]
    table = pd.DataFrame(rows)
    file = Path(__file__).with_suffix(".csv")
    table.to_csv(file, index=False, float_format="%.3f", lineterminator="\n")
    print(table.to_string())


def row(
    name: str, episode_s: float, settle_s: float, population: int, seeds: int, generations: int
) -> Row:
    """Return the row of a model that is trained in one way."""
    timing, objective = Timing(duration_s=episode_s, tick_s=0.002), Fitness(settle_s=settle_s)
    experiment = recipe(name).experiment(timing=timing, objective=objective)
    learner = Evolution(
        algorithm=replace(_STEPS, population=population), stopping=Stopping.after(generations)
    )
    ((progress, _),) = deque(learner.evolve(experiment, tuple(range(seeds))), maxlen=1)
    weights, protocol = np.asarray(progress.best_weights), experiment.protocol
    results = evaluate(
        experiment.controller, weights, experiment.omega, experiment.body, protocol
    ).episodes
    at_omega_t = results["limit_cycle_share"][:, protocol.offsets.index(0.0)]
    means = {metric: float(mean_defined(results[metric].ravel())) for metric in METRICS}
    way = {"episode_s": episode_s, "settle_s": settle_s, "population": population}
    return {"model": name, **way, "share_at_omega_t": float(at_omega_t.mean()), **means}


if __name__ == "__main__":
    main(run)
