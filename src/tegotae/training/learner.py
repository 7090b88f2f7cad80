"""Contract of a learning algorithm, and the state and results of a training."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias

import jax
import numpy as np

from tegotae._support.documents import CODE, Json, JsonObject
from tegotae._support.part_code import code_of
from tegotae.parts.controller import Controller
from tegotae.parts.parameters import Part
from tegotae.systems.descriptions import describe
from tegotae.systems.experiment import Trainable
from tegotae.systems.registry import name_of

if TYPE_CHECKING:
    from tegotae.training.run import Run


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


class Learner(Part, ABC):
    """A learning algorithm and its budget: a frozen dataclass of settings.

    A learner of your own is most easily a `SeedLearner`. Everything else of a training is the same
    whatever learns: its folder, controller files, learning curves and how it is resumed.
    """

    UNIT: ClassVar[str] = "step"
    """Unit in which a training is counted, such as "generation"."""

    @property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""
        return versions_of()

    def engine(self, experiment: Trainable) -> str:
        """Return the engine that decides the numbers; by default that of the experiment's
        evaluator."""
        with experiment.evaluator() as evaluator:
            return evaluator.engine

    def check(self, run: Run[Any]) -> None:
        """Raise `TegotaeError` for an experiment that it cannot learn."""

    def configuration(self, run: Run[Any]) -> JsonObject:
        """Return the settings that decide the result, except its duration, as JSON values.

        By default these are the experiment, the seeds, and all settings with the code of the class.
        """
        code = code_of(type(self))
        noted = {} if code is None else {CODE: code}
        settings = {name: x for name, x in describe(self).items() if name != "kind"}
        return {
            "experiment": run.experiment.document,
            "seeds": list(run.seeds),
            "algorithm": {"name": name_of(type(self)), **noted, **settings},
        }

    @abstractmethod
    def length(self, run: Run[Any]) -> int:
        """Return the number of steps of a whole training."""

    @abstractmethod
    def learn(self, run: Run[Any], state: TrainingState | None = None) -> Iterator[TrainingState]:
        """Learn, and yield the state after each step.

        Args:
            run: the training.
            state: the state to continue from (`resumed`); None from the beginning.
        """

    @abstractmethod
    def resumed(self, run: Run[Any], points: Points, arrays: Arrays) -> TrainingState:
        """Return the state that a training continues from.

        Args:
            run: the training.
            points: its learning curves so far.
            arrays: its arrays (`TrainingState.arrays`).

        Raises:
            ValueError or KeyError: for arrays of another training.
        """


class SeedLearner(Learner):
    """A learner that trains one seed after the other; resumable by seed.

    A subclass says how many `steps` a run has, and yields its `curve`. The controller of a run is
    that of the best point.
    """

    @property
    @abstractmethod
    def steps(self) -> int:
        """Number of steps of each run; it has ended with a point at this step."""

    @abstractmethod
    def curve(self, experiment: Trainable, seed: int) -> Iterator[tuple[CurvePoint, np.ndarray]]:
        """Train a run, and yield the points of its learning curve with their weights.

        Args:
            experiment: what is trained; its `evaluator` scores weights.
            seed: of the weights and of all that is drawn.
        """

    def policy(self, experiment: Trainable) -> Controller:
        """Return the controller of the weights; by default the experiment's."""
        return experiment.controller

    def length(self, run: Run[Any]) -> int:
        """Return the steps of all seeds."""
        return len(run.seeds) * self.steps

    def learn(self, run: Run[Any], state: TrainingState | None = None) -> Iterator[TrainingState]:
        """Yield the state after each point of a learning curve.

        Seeds that are done are left as they are; one that was interrupted begins again, and ends in
        the same numbers.

        Args:
            run: the training.
            state: the state to continue from (`resumed`); None from the beginning.
        """
        points = () if state is None else state.points
        weights = {} if state is None else dict(state.arrays)
        lasted = {point.seed: point.step for point in points}
        finished = {seed for seed, step in lasted.items() if step >= self.steps}
        points = tuple(point for point in points if point.seed in finished)
        for i, seed in enumerate(run.seeds):
            if seed in finished:
                continue
            best = -math.inf
            for yielded, reached in self.curve(run.experiment, seed):
                point = CurvePoint(seed, *map(float, yielded[1:]))
                if point.fitness > best or best == -math.inf:
                    best, weights = point.fitness, {**weights, _weights_name(seed): reached}
                points = (*points, point)
                yield TrainingState(
                    i * self.steps + min(round(point.step), self.steps),
                    f"seed {seed}  {_report(point)}",
                    points,
                    (point,),
                    self._learned(run, points, weights),
                    weights,
                )

    def resumed(self, run: Run[Any], points: Points, arrays: Arrays) -> TrainingState:
        """Return the state with the best weights of every seed that has begun.

        Raises:
            ValueError or KeyError: for arrays of another training.
        """
        shape = (run.experiment.controller.n_weights,)
        if any(arrays[_weights_name(point.seed)].shape != shape for point in points):
            raise ValueError("shapes differ")
        learned = self._learned(run, points, arrays)
        return TrainingState(points=points, learned=learned, arrays=arrays)

    def _learned(
        self, run: Run[Any], points: Points, weights: Arrays
    ) -> tuple[LearnedController, ...]:
        """Return the controller of each seed's best point."""
        learned = []
        for seed in run.seeds:
            curve = [point for point in points if point.seed == seed]
            if curve:
                best = max(curve, key=lambda point: point.fitness)
                outcome = {
                    "seed": seed,
                    f"{self.UNIT}s": curve[-1].step,
                    "simulated_s": curve[-1].simulated_s,
                    "best_fitness": best.fitness,
                    f"best_{self.UNIT}": best.step,
                }
                policy = self.policy(run.experiment)
                learned.append(LearnedController(policy, weights[_weights_name(seed)], outcome))
        return tuple(learned)


def _weights_name(seed: int) -> str:
    """Return the name of a seed's best weights in a checkpoint."""
    return f"seed{seed}_weights"


def _report(point: CurvePoint) -> str:
    """Return a point in words, by CoT⁻¹ where it is measured."""
    if math.isnan(point.cot_inverse):
        return f"fitness {point.fitness:+.3f}"
    return f"CoT⁻¹ {point.cot_inverse:.3f} m/J"


def initial_weights(controller: Controller, seed: int) -> np.ndarray:
    """Return the weights that the training of a seed starts from, [n_weights].

    They are those of `tegotae.training.evolution.Evolution.start`, to rounding.

    Args:
        controller: whose weights.
        seed: of the training.
    """
    key_weights, _ = jax.random.split(jax.random.key(seed))
    return np.asarray(controller.initial(key_weights), np.float32)


def versions_of(*packages: str) -> dict[str, str]:
    """Return the versions of the programs that decide the numbers: these packages and their
    dependencies.
    """
    return {name: version(name) for name in ("tegotae", "jax", "jaxlib", *packages, "numpy")}
