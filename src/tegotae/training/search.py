"""The constant gain σ of a pure V model, found by search (the paper: "empirically tuned")."""

from __future__ import annotations

import numpy as np

from tegotae.bodies import Body
from tegotae.controller import Controller
from tegotae.rollout import Engine, Scenario, Timing
from tegotae.training.fitness import EPISODE, Fitness

GAINS = np.linspace(0.1, 12.0, 240)
"""Values of σ that are tried [rad/(s N)]."""


def best_gain(
    controller: Controller,
    omega: float,
    body: Body | None = None,
    *,
    fitness: Fitness | None = None,
    timing: Timing | None = None,
    release_m: float = 1.2,
) -> tuple[float, float]:
    """The σ of highest fitness on a fixed grid, and that fitness; deterministic.

    Args:
        controller: one whose only weight is σ.
        omega: prescribed frequency ω [rad/s].
        body: the body; the paper's hopper by default.
        fitness: the measure.
        timing: the episode.
        release_m: height of the release [m], at rest.
    """
    engine = Engine(
        controller=controller,
        timing=timing or EPISODE,
        summary=fitness or Fitness(),
    )
    outcome = engine.run(GAINS[:, None], Scenario(omega=omega, height_m=release_m), body)
    best = int(np.argmax(outcome["fitness"]))
    return float(GAINS[best]), float(outcome["fitness"][best])
