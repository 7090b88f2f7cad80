"""Fitness of candidate weights, on the engine and anywhere; the gain of a vanilla controller."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import numpy as np

from tegotae._support.engines import XLA
from tegotae._support.transforms import jit_in_one_module
from tegotae.measures.objectives.objective import (
    EpisodeSummary,
    Objective,
    Scores,
    scores,
)
from tegotae.simulation.draws import Randomization
from tegotae.simulation.episode import LaneInputs
from tegotae.simulation.loop import check_senses
from tegotae.simulation.rollout import Rollout
from tegotae.simulation.timing import by_blocks
from tegotae.simulation.world import Scenario

_LANES_SCORED = 64
"""Lanes of a block that is scored at a time."""


class Generation(NamedTuple):
    """The runs whose candidates are evaluated, and when."""

    seeds: tuple[int, ...]
    """The runs."""
    going: np.ndarray
    """True for seeds that have not ended, [seeds]."""
    number: int | None = None
    """Number of the generation. The last candidate of every seed is then the centre of its
    distribution; without a number all are of one kind, and meet the same episodes."""

    @classmethod
    def alike(cls) -> Generation:
        """Make a generation of one seed whose candidates all meet the same episodes."""
        return cls((0,), np.array([True]))


class Evaluator(AbstractContextManager["Evaluator"]):
    """Scores candidates' weights by episodes, wherever these take place; a context manager.

    The optimiser's loop (`tegotae.training.evolution`) hands it arrays and gets arrays.
    """

    @property
    @abstractmethod
    def repeats(self) -> int:
        """Evaluation repeats per candidate."""

    @abstractmethod
    def scored(self, weights: np.ndarray, per_seed: int, generation: Generation) -> Scores:
        """Evaluate rows of weights, [going, rows].

        Args:
            weights: of the seeds that are going, [going, rows, n_weights].
            per_seed: how many rows of a seed come first that do not meet the evaluation set.
            generation: the seeds, and their generation.
        """

    def evaluate(self, candidates: np.ndarray, generation: Generation) -> Scores:
        """Evaluate every candidate of the seeds that continue.

        Args:
            candidates: weights, [seeds, candidates, n_weights].
            generation: the seeds, and their generation.
        """
        per_seed, going = candidates.shape[1], generation.going
        repeats = 0 if generation.number is None else per_seed - 1
        # What meets the evaluation set does so as several candidates.
        times = np.where(np.arange(per_seed) < repeats, 1, self.repeats)
        rows = np.repeat(candidates[going], times, axis=1)

        def of_candidates(values: np.ndarray) -> np.ndarray:
            """Return values [seeds, candidates], reduced over the rows of each candidate."""
            again = values[:, repeats:].reshape(len(values), -1, self.repeats)
            together = again.any(axis=-1) if values.dtype == bool else self.mean(again)
            padded = np.zeros(candidates.shape[:2], values.dtype)
            padded[going] = np.concatenate([values[:, :repeats], together], axis=1)
            return padded

        return Scores(*map(of_candidates, self.scored(rows, repeats, generation)))

    def alike(self, weights: np.ndarray) -> Scores:
        """Score candidates that all meet the same episodes, [candidates] each.

        Args:
            weights: [candidates, n_weights].
        """
        candidates = np.asarray(weights, "float32")[None]
        return Scores(*(x[0] for x in self.evaluate(candidates, Generation.alike())))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means over the last axis."""
        return values.mean(axis=-1)

    @property
    def program(self) -> tuple[Any, ...]:
        """The compiled part of it; hashable."""
        return ()

    @property
    def engine(self) -> str:
        """The engine that computes its numbers; XLA's for numbers without a rollout."""
        return XLA

    def close(self) -> None:
        """Release its resources, such as worker processes."""

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True, eq=False)
class EngineEvaluator(Evaluator):
    """Scores by episodes of this package's engine: all candidates in one compiled program.

    Args:
        rollouts: what rolls the episodes out.
        fitness: by what measure; what of an episode counts is the engine's summary.
        varied: body and scenario, and in what the episodes differ.
        episodes: how many episodes each candidate has, on average; the evaluation set has at least
            `LEAST_EVALUATION_SET`.

    Raises:
        TegotaeError: for a body that does not go with the controller or the control period.
    """

    rollouts: Rollout
    fitness: Objective
    varied: Randomization
    episodes: int = 1

    def __post_init__(self) -> None:
        check_senses(self.rollouts.controller, self.varied.body)
        self.varied.body.check_tick(self.rollouts.timing.tick_s)

    @property
    def program(self) -> tuple[Rollout, Objective, int]:
        """The compiled part: settings of the fitness are data."""
        fitness = self.fitness.program
        return (
            dataclasses.replace(self.rollouts, summary=EpisodeSummary(fitness)),
            fitness,
            self.episodes,
        )

    @property
    def engine(self) -> str:
        """The engine that rolls the episodes out."""
        rollout, *_ = self.program
        sample = np.zeros((1, 1, rollout.controller.n_weights))
        episode = self.varied.evaluation_set(1, self.episodes)
        return rollout.runs_on(self._lanes(sample, np.array([True]), episode), self.varied.body)

    @property
    def repeats(self) -> int:
        """Evaluation repeats per candidate."""
        return self.varied.repeats(self.episodes)

    def scored(self, weights: np.ndarray, per_seed: int, generation: Generation) -> Scores:
        """Evaluate rows of weights; ended seeds cost only the rest of a block."""
        going, of_set = generation.going, self.repeats * self.episodes
        if generation.number is None:
            candidates = len(going) * weights.shape[1] // self.repeats
            episode = self.varied.evaluation_set(candidates, of_set)
        else:
            drawn = generation.number, per_seed, self.episodes, of_set
            episode = self.varied.generation(generation.seeds, *drawn)
        rollout, fitness, _ = self.program
        outcome = rollout.run_lanes(self._lanes(weights, going, episode), self.varied.body)
        score = partial(_scored, fitness, data=self.fitness.data)
        of_lanes = by_blocks(score, outcome, _LANES_SCORED)
        of_rows = (of_lanes[name].reshape(*weights.shape[:2], -1) for name in Scores._fields)
        return Scores(*((x.any if x.dtype == bool else x.mean)(axis=-1) for x in of_rows))

    def _lanes(self, weights: np.ndarray, going: np.ndarray, episode: Scenario) -> LaneInputs:
        """Return one lane for each episode of each row of weights."""
        seeds, per_seed = len(going), weights.shape[1] * self.episodes

        def of_lanes(x: Any) -> np.ndarray:
            """Return one value per lane, seed by seed; a value common to all may be given once."""
            x = np.atleast_1d(np.asarray(x, "float32"))
            every = np.broadcast_to(x, (*x.shape[:-1], seeds * per_seed))
            by_seed = every.reshape(*every.shape[:-1], seeds, per_seed)[..., going, :]
            return by_seed.reshape(*every.shape[:-1], -1)

        rows = np.repeat(np.asarray(weights, "float32"), self.episodes, axis=1)
        columns = np.ascontiguousarray(rows.reshape(-1, weights.shape[-1]).T)
        return LaneInputs(columns, jax.tree.map(of_lanes, episode))


_scored = jit_in_one_module(scores, (0,))
