"""The constant gain σ of a pure V model, found by search (the paper: "empirically tuned")."""

from __future__ import annotations

import numpy as np

from tegotae.experiment import Experiment
from tegotae.rollout import Engine

GAINS = np.linspace(0.1, 12.0, 240)
"""Values of σ that are tried [rad/(s N)]."""


def best_gain(experiment: Experiment) -> tuple[float, float]:
    """The σ of highest fitness on a fixed grid, and that fitness; deterministic.

    Args:
        experiment: one whose controller's only weight is σ.
    """
    engine = Engine(
        controller=experiment.controller,
        integrator=experiment.integrator,
        timing=experiment.timing,
        summary=experiment.measure,
    )
    outcome = engine.run(GAINS[:, None], experiment.scenario, experiment.body)
    best = int(np.argmax(outcome["fitness"]))
    return float(GAINS[best]), float(outcome["fitness"][best])
