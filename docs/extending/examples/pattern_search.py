"""A learner: move every weight up and down, keep the best move, or halve the step."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tegotae.parts.parameters import positive, whole
from tegotae.systems.experiment import Trainable
from tegotae.training.learner import CurvePoint, SeedLearner, initial_weights


@dataclass(frozen=True, kw_only=True)
class PatternSearch(SeedLearner):
    """The pattern search of Hooke and Jeeves, from random weights."""

    NAME = "pattern-search"  # what commands and documents call it
    UNIT = "round"

    rounds: int = whole(40)
    """Rounds of each run."""
    step: float = positive(0.5)
    """First step of every weight."""

    @property
    def steps(self) -> int:
        """Rounds of each run."""
        return self.rounds

    def curve(self, experiment: Trainable, seed: int) -> Iterator[tuple[CurvePoint, np.ndarray]]:
        """Yield a point and the best weights after each round."""
        weights, step = initial_weights(experiment.controller, seed), self.step
        moves = np.concatenate([np.zeros((1, weights.size)), np.eye(weights.size)])
        moves = np.concatenate([moves, -moves[1:]])
        simulated_s = 0.0
        with experiment.evaluator() as evaluator:
            for number in range(1, self.rounds + 1):
                candidates = weights + step * moves
                scores = evaluator.alike(candidates)
                simulated_s += len(moves) * evaluator.repeats * experiment.duration_s
                best = int(np.argmax(scores.fitness))
                weights, step = candidates[best], step if best else 0.5 * step
                fitness, cot_inverse = scores.fitness[best], scores.cot_inverse[best]
                yield CurvePoint(seed, number, simulated_s, fitness, cot_inverse), weights
