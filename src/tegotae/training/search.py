"""The constant gain σ of a pure V model, found by search (the paper: "empirically tuned")."""

from __future__ import annotations

import numpy as np

from tegotae.systems.experiment import GAINS
from tegotae.training.evaluator import Generation, evaluator_of
from tegotae.training.trainable import Trainable

__all__ = ["GAINS", "best_gain"]


def best_gain(experiment: Trainable, workers: int | None = None) -> tuple[float, float]:
    """The σ of highest fitness on a fixed grid, and that fitness; deterministic.

    Under changing conditions every σ meets the same episodes, the evaluation set.

    Args:
        experiment: one whose controller's only weight is σ.
        workers: worker processes, where episodes are not the engine's.
    """
    gains = experiment.gains
    with evaluator_of(experiment, workers) as evaluator:
        tried = evaluator.evaluate(gains[None, :, None].astype("float32"), Generation.alike())
    best = int(np.argmax(tried.fitness[0]))
    return float(gains[best]), float(tried.fitness[0, best])
