"""The constant gain σ of a pure V model, found by search (the paper: "empirically tuned")."""

from __future__ import annotations

import numpy as np

from tegotae.systems.experiment import GAINS, Experiment
from tegotae.training.evaluator import Generation, evaluator_of
from tegotae.training.trainable import Trainable

__all__ = ["GAINS", "best_gain"]


def best_gain(experiment: Trainable, workers: int | None = None) -> tuple[float, float]:
    """The σ of highest fitness on a fixed grid, and that fitness; deterministic.

    Of several frequencies (`Experiment.search_offsets`) it is the mean fitness that counts.

    Under changing conditions every σ meets the same episodes, the evaluation set.

    Args:
        experiment: one whose controller's only weight is σ.
        workers: worker processes, where episodes are not the engine's.
    """
    gains = experiment.gains
    weights = gains[None, :, None].astype("float32")
    tried = []
    for system in _at_offsets(experiment):
        with evaluator_of(system, workers) as evaluator:
            tried.append(evaluator.evaluate(weights, Generation.alike()).fitness[0])
    fitness = tried[0] if len(tried) == 1 else np.mean(tried, axis=0)
    best = int(np.argmax(fitness))
    return float(gains[best]), float(fitness[best])


def _at_offsets(experiment: Trainable) -> list[Trainable]:
    """The experiment at each frequency at which a gain is evaluated."""
    if not isinstance(experiment, Experiment) or experiment.omega is None:
        return [experiment]
    if experiment.search_offsets == (0.0,):
        return [experiment]
    omega = experiment.omega
    return [experiment.replaced(omega=omega + offset) for offset in experiment.search_offsets]
