"""Contracts of a training: the learning algorithm, the trained system and the result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from tegotae._support.documents import Json
from tegotae.parts.controller import Controller

if TYPE_CHECKING:
    from tegotae.systems.experiment import Experiment
    from tegotae.training.agents.learner import AgentLearner
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.evolution import Evolution


class CurvePoint(NamedTuple):
    """A point of a learning curve; its fields are the columns of `curves.csv`."""

    seed: int
    step: float
    simulated_s: float
    fitness: float
    cot_inverse: float
    mean_fitness: float = math.nan
    best_fitness: float = math.nan
    failed_share: float = math.nan


Points: TypeAlias = tuple[CurvePoint, ...]
Arrays: TypeAlias = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class LearnedController:
    """Result of the training of one seed.

    Args:
        controller: the controller, as it is with these weights.
        weights: the best so far, shape [n_weights].
        outcome: the result of the training: `seed`, `best_fitness`, and the learner's own entries.
    """

    controller: Controller
    weights: np.ndarray
    outcome: Mapping[str, Json]


@dataclass(frozen=True, eq=False)
class TrainingState:
    """State of a training after a step: its results, and all that it resumes from.

    Args:
        done: how far it is, of the learner's `length`.
        report: how it goes, in a few words.
        points: the learning curves of all seeds.
        new: the points of the last step.
        learned: the controllers, of every seed that has begun.
        arrays: the learner's own state by name; empty if it begins anew.
    """

    done: int = 0
    report: str = ""
    points: Points = ()
    new: Points = ()
    learned: tuple[LearnedController, ...] = ()
    arrays: Arrays = field(default_factory=dict[str, np.ndarray])


Trainable: TypeAlias = "Experiment | EnvExperiment"
"""Trainable experiment: on the engine, or on an environment."""


Learner: TypeAlias = "Evolution | AgentLearner"
"""Learning algorithm and its budget: a population or an agent, frozen dataclasses of settings.

Of a `tegotae.training.run.Run` each says what it is counted in (`UNIT`), the versions and the
`engine` that decide the numbers, its `configuration` and `length`; it can `check` it, `learn` step
by step, and go on from what an earlier training left (`resumed`).
"""


def versions_of(*packages: str) -> dict[str, str]:
    """Versions of the programs that decide the numbers: these packages and what all need."""
    return {name: version(name) for name in ("tegotae", "jax", "jaxlib", *packages, "numpy")}
