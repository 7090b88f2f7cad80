"""A population that learns: an evolution strategy, generation by generation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import jax
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.limits import require_memory
from tegotae.measures.hopping.statistics import mean_defined
from tegotae.systems.descriptions import check_kept
from tegotae.training.algorithms import PGPE, Algorithm
from tegotae.training.algorithms.document import algorithm_document
from tegotae.training.evaluator import best_gain, evaluator_of
from tegotae.training.evolve import SEARCH, Curves, Progress, Stopping, evolve, start
from tegotae.training.folder import versions_of
from tegotae.training.learner import (
    CurvePoint,
    LearnedController,
    Learner,
    LearningStep,
    Session,
    Trainable,
)


@dataclass(frozen=True, kw_only=True)
class Evolution(Learner):
    """Learning by an evolution strategy, all seeds side by side; resumable by generation.

    A pure V model has no network: its σ is found by search, which is one run whatever the seeds.

    Args:
        algorithm: the strategy.
        stopping: when a seed ends; `Stopping.after(n)` for exactly n generations.
        workers: worker processes, where episodes are not the engine's; one a core by default. With
            another number of them results differ by rounding, which training magnifies.

    Example:
        >>> Evolution(stopping=Stopping.after(8)).UNIT
        'generation'
    """

    algorithm: Algorithm = field(default_factory=PGPE)
    stopping: Stopping = field(default_factory=Stopping)
    workers: int | None = None

    UNIT = "generation"

    @property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""
        return versions_of("evosax")

    def engine(self, experiment: Trainable) -> str:
        """The evaluator's."""
        with evaluator_of(experiment) as evaluator:
            return evaluator.engine

    def check(self, experiment: Trainable) -> None:
        """It learns whatever has weights (`Experiment.check`)."""

    def configuration(self, experiment: Trainable, seeds: tuple[int, ...]) -> JsonObject:
        """What decides the result, but for the cap on generations, as JSON values."""
        return {
            "experiment": experiment.document,
            "seeds": list(seeds),
            "algorithm": algorithm_document(self.algorithm),
            "stopping": self.stopping.rule,
        }

    def session(self, experiment: Trainable, seeds: tuple[int, ...]) -> Session:
        """The learning of an experiment: generations, or the search of a gain."""
        check_kept(self.algorithm)
        self._require_room(experiment, seeds)
        if experiment.is_searched:
            return GainSearch(self, experiment, seeds)
        return EvolutionSession(self, experiment, seeds)

    def program(self, experiment: Trainable) -> tuple[object, ...]:
        """The compiled part: trainings with an equal one share it."""
        with evaluator_of(experiment) as evaluator:
            return (self.algorithm.program, *evaluator.program)

    def start(self, experiment: Trainable, seeds: Sequence[int]) -> Progress:
        """Every seed's own random weights."""
        return start(self.algorithm, experiment.controller, seeds)

    def evolve(
        self,
        experiment: Trainable,
        seeds: Sequence[int],
        progress: Progress | None = None,
        fitness: ArrayLike | None = None,
    ) -> Iterator[tuple[Progress, Curves]]:
        """Learn on until every seed has ended, from random weights if there is no progress.

        See `tegotae.training.evolve.evolve`.
        """
        if progress is None:
            progress = self.start(experiment, seeds)
        with evaluator_of(experiment, self.workers) as evaluator:
            yield from evolve(
                self.algorithm, evaluator, progress, seeds, self.stopping, fitness=fitness
            )

    def search(self, experiment: Trainable) -> tuple[float, float]:
        """The σ of a pure V model, and its fitness."""
        return best_gain(experiment, self.workers)

    def ends(self, curves: Sequence[Curves]) -> list[str]:
        """Why each seed has ended: on its plateau, at the cap, or not yet (empty)."""
        return self.stopping.reasons(np.array([c.centre_fitness for c in curves]))

    def _require_room(self, experiment: Trainable, seeds: tuple[int, ...]) -> None:
        """Raise `TegotaeError` if a generation's weights and noise would not fit into memory."""
        episodes = self.algorithm.population * experiment.episodes
        n_weights = experiment.controller.n_weights
        require_memory(
            8.0 * 4 * len(seeds) * episodes * n_weights,
            f"{episodes} episodes a generation, of {len(seeds)} seeds and {n_weights} weights,",
        )


class EvolutionSession(Session):
    """Generations of all seeds side by side.

    Args:
        learner: how is learned.
        experiment: what is learned.
        seeds: one training from random weights each.
    """

    def __init__(self, learner: Evolution, experiment: Trainable, seeds: tuple[int, ...]) -> None:
        self._learner, self._experiment, self._seeds = learner, experiment, seeds
        self._reached: tuple[Progress | None, list[Curves]] = None, []

    @property
    def length(self) -> int:
        """The cap on generations."""
        return self._learner.stopping.generations

    def steps(self) -> Iterator[LearningStep]:
        """A generation each."""
        progress, curves = self._reached
        if progress is None:
            progress = self._learner.start(self._experiment, self._seeds)
        fitness = [each.centre_fitness for each in curves]
        evolving = self._learner.evolve(self._experiment, self._seeds, progress, fitness)
        for after, new in evolving:
            # In one assignment: an interrupt must not come between the two.
            self._reached = after, [*self._reached[1], new]
            done = len(self._reached[1])
            yield LearningStep(done, self._report(after, new), tuple(self._points(done - 1, new)))

    def _report(self, progress: Progress, new: Curves) -> str:
        ended = sum(map(bool, self._learner.ends(self._reached[1])))
        mean = float(mean_defined(np.asarray(new.centre_cot_inverse)))
        measured = ["CoT⁻¹", f"{mean:.3f}", *self._experiment.cot_unit.split()]
        return (
            f"fitness {float(np.mean(progress.best_fitness)):+.3f}  "
            f"{'' if math.isnan(mean) else ' '.join(measured) + '  '}"
            f"{ended} of {len(self._seeds)} runs ended"
        )

    def _points(self, generation: int, curves: Curves) -> Iterator[CurvePoint]:
        """A generation's points, of the seeds that it had."""
        episodes = self._learner.algorithm.population * self._experiment.episodes
        simulated_s = generation * episodes * self._experiment.duration_s
        for i, seed in enumerate(self._seeds):
            found = (float(column[i]) for column in curves)
            if not math.isnan(curves.centre_fitness[i]):
                yield CurvePoint(seed, generation, simulated_s, *found)

    def points(self) -> list[CurvePoint]:
        """A point a generation; what it says is of the distribution that the generation had."""
        curves = self._reached[1]
        return [point for g, each in enumerate(curves) for point in self._points(g, each)]

    def learned(self) -> list[LearnedController]:
        """The mean of the best distribution of each seed."""
        progress, curves = self._reached
        if progress is None or not curves:
            return []
        return [
            LearnedController(
                self._experiment.controller,
                np.asarray(progress.best_weights[i]),
                {
                    "seed": seed,
                    "generations": int(progress.generation[i]),
                    "ended": reason,
                    "best_fitness": float(progress.best_fitness[i]),
                    "best_generation": int(progress.best_generation[i]),
                },
            )
            for i, (seed, reason) in enumerate(
                zip(self._seeds, self._learner.ends(curves), strict=True)
            )
        ]

    def arrays(self) -> dict[str, np.ndarray]:
        """The optimiser's state, and the curves of all generations."""
        progress, curves = self._reached
        if progress is None or not curves:
            return {}
        arrays = {f"leaf{i}": np.asarray(x) for i, x in enumerate(jax.tree.leaves(progress))}
        for name in Curves._fields:
            arrays[f"curve_{name}"] = np.stack([getattr(each, name) for each in curves])
        return arrays

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on behind the last generation."""
        leaves, structure = jax.tree.flatten(self._learner.start(self._experiment, self._seeds))
        restored = [arrays[f"leaf{i}"] for i in range(len(leaves))]
        columns = [arrays[f"curve_{name}"] for name in Curves._fields]
        for ours, theirs in zip(leaves, restored, strict=True):
            if (ours.shape, ours.dtype) != (theirs.shape, theirs.dtype):
                raise ValueError("shapes or types differ")
        curves = [Curves(*generation) for generation in zip(*columns, strict=True)]
        reached = jax.tree.unflatten(structure, [jax.numpy.asarray(x) for x in restored])
        if np.max(reached.generation) != len(curves):
            raise ValueError("curves and progress differ in length")
        if len(curves) > self.length:
            raise TegotaeError(
                f"generations is {self.length}, and {len(curves)} have been trained already; ask "
                "for as many or more, or choose another folder with --out"
            )
        self._reached = reached, curves


class GainSearch(Session):
    """The search of the gain σ of a pure V model; it has no randomness, and so one seed.

    Args:
        learner: how is learned.
        experiment: what is learned.
        seeds: the first is what the result is called by.
    """

    def __init__(self, learner: Evolution, experiment: Trainable, seeds: tuple[int, ...]) -> None:
        self._learner, self._experiment, self._seeds = learner, experiment, seeds
        self._found: tuple[float, float] | None = None

    @property
    def length(self) -> int:
        """All gains are one step."""
        return 1

    def steps(self) -> Iterator[LearningStep]:
        """All gains at once."""
        self._found = self._learner.search(self._experiment)
        yield LearningStep(1, f"fitness {self._found[1]:+.3f}", ())

    def points(self) -> list[CurvePoint]:
        """None: nothing is learned."""
        return []

    def learned(self) -> list[LearnedController]:
        """The best gain."""
        if self._found is None:
            return []
        gain, fitness = self._found
        outcome = {
            "seed": self._seeds[0],
            "best_fitness": fitness,
            "generations": 0,
            "ended": SEARCH,
            "best_generation": 0,
        }
        return [LearnedController(self._experiment.controller, np.array([gain]), outcome)]

    def arrays(self) -> dict[str, np.ndarray]:
        """None: it begins anew."""
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """It has no state."""
