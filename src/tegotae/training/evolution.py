"""A population that learns: an evolution strategy, generation by generation, and when it ends."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.engines import check_jax
from tegotae._support.errors import TegotaeError
from tegotae._support.limits import require_memory
from tegotae._support.transforms import jit_in_one_module
from tegotae.measures.objectives.evaluator import Generation
from tegotae.measures.objectives.objective import Scores
from tegotae.measures.statistics import mean_defined
from tegotae.parts._shapes import AnyArray
from tegotae.parts.controller import Controller
from tegotae.parts.parameters import Part, not_negative, positive, whole
from tegotae.systems.descriptions import check_kept
from tegotae.systems.experiment import Trainable
from tegotae.training.algorithms import PGPE, Algorithm, Parameters, SearchState, algorithm_document
from tegotae.training.learner import (
    Arrays,
    CurvePoint,
    LearnedController,
    Learner,
    Points,
    TrainingState,
    versions_of,
)
from tegotae.training.scoring import best_gain

if TYPE_CHECKING:
    from tegotae.training.run import Run

_NEVER = 2**31

RUNNING, PLATEAU, CAP = "", "plateau", "cap"
"""Reasons for a run's end; the first if it has not ended."""

SEARCH = "search"
"""The end of what is not trained but searched for: a pure V model's σ."""

_LEVEL = 0
"""XLA's effort for programs that run once a generation: they take longer to compile well than they
ever run."""


@dataclass(frozen=True, kw_only=True)
class Stopping(Part):
    """Stop a run once its fitness is on a plateau, or at a cap.

    With b(g) the best fitness of the distribution's mean over the first g generations, a run is on
    a plateau after g generations if

        b(g) - b(g - ⌈share · g⌉) <= tolerance   and   g >= least.

    The wait grows with the training, so that a run which found something late is given its time
    again. A jump that comes after a longer wait than this is missed. Each run is decided alone.

    Args:
        generations: the cap: no run has more generations.
        least: generations before which no plateau is seen.
        share: of the training so far, at its end, in which nothing may be gained.
        tolerance: what counts as nothing, in units of the fitness [m/J].

    Raises:
        TegotaeError: for a count below one, a share that is not between 0 and 1, or a negative
            tolerance.

    Example:
        >>> rule = Stopping(generations=100, least=10, share=0.5, tolerance=0.01)
        >>> [rule.reason(np.minimum(np.arange(n), 8.0)) for n in (10, 17, 18)]
        ['', '', 'plateau']
    """

    generations: int = whole(480)
    least: int = whole(240)
    share: float = positive(0.5)
    tolerance: float = not_negative(0.02)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.share >= 1.0:
            raise TegotaeError(
                f"share is {self.share:g}; it must be less than 1: the part of a training that "
                "gives no gain"
            )

    @classmethod
    def after(cls, generations: int) -> Stopping:
        """Stop after exactly so many generations, plateau or not."""
        return cls(generations=generations, least=_NEVER)

    @property
    def rule(self) -> dict[str, float]:
        """The settings of the rule except the cap: a training continues under a higher cap, but
        not under another rule.
        """
        return {"least": self.least, "share": self.share, "tolerance": self.tolerance}

    def reason(self, fitness: np.ndarray) -> str:
        """Return the reason why a run ends after these generations, or the empty string if it
        continues.

        Args:
            fitness: of the distribution's mean, generation by generation, shape [generations].
        """
        generations = len(fitness)
        first = generations - math.ceil(self.share * generations)
        if generations >= self.least and first >= 1:
            gain = np.max(fitness) - np.max(fitness[:first])
            if gain <= self.tolerance:
                return PLATEAU
        return CAP if generations >= self.generations else RUNNING

    def reasons(self, curves: np.ndarray) -> list[str]:
        """Return the reasons for runs side by side; a run's curve ends in NaN where it has ended.

        Args:
            curves: shape [generations, runs].
        """
        curves = np.asarray(curves, float)
        return [self.reason(run[~np.isnan(run)]) for run in curves.T]


class Progress(NamedTuple):
    """State of a training after some generations; arrays with one entry per seed.

    Seeds that have ended stand still.
    """

    generation: AnyArray
    """Generations done."""
    search: SearchState
    """The optimiser's state."""
    best_fitness: AnyArray
    """Fitness of the best distribution seen."""
    best_weights: AnyArray
    """Mean of that distribution, shape [seeds, n_weights]."""
    best_std: AnyArray
    """Its standard deviation, shape [seeds, n_weights]."""
    best_generation: AnyArray
    """The generation in which it was seen."""


class Curves(NamedTuple):
    """One generation's learning curves, each of shape [seeds]; NaN where a seed has ended."""

    centre_fitness: AnyArray
    """Fitness of the distribution's mean."""
    centre_cot_inverse: AnyArray
    """CoT⁻¹ of the distribution's mean [m/J]."""
    mean_fitness: AnyArray
    """Mean fitness of the samples that did not fail."""
    best_fitness: AnyArray
    """Fitness of the best sample."""
    failed_share: AnyArray
    """Share of the samples that failed."""


@dataclass(frozen=True, kw_only=True)
class Evolution(Learner):
    """Learning by an evolution strategy, all seeds side by side; resumable by generation.

    A pure V model has no network: its σ is found by search, which is one run whatever the seeds.

    Args:
        algorithm: the strategy.
        stopping: when a seed ends; `Stopping.after(n)` for exactly n generations.
        workers: worker processes, where episodes are not the engine's; one a core by default. With
            another number of them results differ by rounding, which training magnifies.
        weights: where each seed begins, in place of its own random weights.

    Example:
        >>> Evolution(stopping=Stopping.after(8)).UNIT
        'generation'
    """

    algorithm: Algorithm = field(default_factory=PGPE)
    stopping: Stopping = field(default_factory=Stopping)
    workers: int | None = None
    weights: tuple[float, ...] = ()

    UNIT: ClassVar[str] = "generation"

    @property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers."""
        return versions_of(*self.algorithm.LIBRARIES)

    def check(self, run: Run[Any]) -> None:
        """Raise `TegotaeError` if a generation's weights and noise would not fit into memory, or
        the algorithm is not installed."""
        self.algorithm.check()
        episodes, seeds = self.algorithm.population * run.experiment.episodes, len(run.seeds)
        n_weights = run.experiment.controller.n_weights
        require_memory(
            8.0 * 4 * seeds * episodes * n_weights,
            f"{episodes} episodes a generation, of {seeds} seeds and {n_weights} weights,",
        )

    def configuration(self, run: Run[Any]) -> JsonObject:
        """Return the settings that decide the result, except the cap on generations, as JSON
        values."""
        begins = {"weights": list(self.weights)} if self.weights else {}
        return {
            "experiment": run.experiment.document,
            "seeds": list(run.seeds),
            "algorithm": algorithm_document(self.algorithm),
            "stopping": self.stopping.rule,
            **begins,
        }

    def program(self, experiment: Trainable) -> tuple[object, ...]:
        """Return the compiled part, which trainings with an equal one share."""
        with experiment.evaluator() as evaluator:
            return (self.algorithm.program, *evaluator.program)

    def start(self, experiment: Trainable, seeds: Sequence[int]) -> Progress:
        """Start every seed, independently of the other seeds.

        Warns of a part that could not be saved with what it learns.

        Raises:
            TegotaeError: for settings of JAX with which results would be others.
        """
        check_jax()
        try:
            check_kept((self.algorithm, experiment.controller))
        except TegotaeError as error:
            warnings.warn(f"what is learned could not be saved: {error}", stacklevel=2)
        first = np.asarray(self.weights, "float32") if self.weights else None
        return _initial_arrays(
            self.algorithm, experiment.controller, np.asarray(seeds, "int32"), first
        )

    def evolve(
        self,
        experiment: Trainable,
        seeds: Sequence[int],
        begun: Progress | None = None,
        fitness: Iterable[AnyArray] = (),
    ) -> Iterator[tuple[Progress, Curves]]:
        """Learn on, one generation at a time, until every seed has ended.

        Args:
            experiment: what is learned.
            seeds: one training each.
            begun: where an earlier training of these seeds stopped; from random weights if None.
            fitness: of that training its `Curves.centre_fitness`, [generations, seeds].

        Yields:
            the new progress and the generation's curves (NumPy arrays).
        """
        progress = self.start(experiment, seeds) if begun is None else begun
        # As host arrays the start and later progress are of the same type: one compilation.
        progress = jax.tree.map(np.asarray, progress)
        algorithm, numbers = self.algorithm, np.asarray(seeds, "int32")
        parameters = algorithm.parameters(progress.best_weights.shape[-1])
        curve = [*fitness]
        with experiment.evaluator(self.workers) as evaluator:
            while True:
                ended = self.stopping.reasons(np.array(curve).reshape(len(curve), len(seeds)))
                going = np.array([reason == RUNNING for reason in ended])
                if not going.any():
                    return
                search, drawn = _ask(algorithm.program, parameters, progress, numbers)
                candidates = np.asarray(drawn)
                scores = evaluator.evaluate(candidates, Generation(tuple(seeds), going, len(curve)))
                arguments = parameters, progress, search, candidates, scores, numbers, going
                updated = _tell(algorithm.program, *arguments)
                progress, curves = jax.tree.map(np.asarray, updated)
                curve.append(curves.centre_fitness)
                yield progress, curves

    def length(self, run: Run[Any]) -> int:
        """Return the cap on generations."""
        return self.stopping.generations

    def learn(self, run: Run[Any], state: TrainingState | None = None) -> Iterator[TrainingState]:
        """Yield the state after each generation, or after the search of a gain at once.

        Args:
            run: the training.
            state: where it goes on (`resumed`), or None from the beginning.
        """
        experiment, seeds = run.experiment, run.seeds
        if experiment.is_searched:
            yield self._searched(run)
            return
        state = state or TrainingState()
        points = state.points
        begun = self._progress(run, state.arrays) if state.arrays else None
        episodes = self.algorithm.population * experiment.episodes
        for progress, curves in self.evolve(experiment, seeds, begun, _fitness(points, seeds)):
            generation = int(np.max(progress.generation))
            simulated_s = (generation - 1) * episodes * experiment.duration_s
            rows = zip(seeds, *curves, strict=True)
            new = tuple(
                CurvePoint(seed, generation - 1, simulated_s, *map(float, row))
                for seed, *row in rows
                if not math.isnan(row[0])
            )
            points = (*points, *new)
            yield self._state(run, points, progress, new)

    def resumed(self, run: Run[Any], points: Points, arrays: Arrays) -> TrainingState:
        """Return the state after the last generation whose points and arrays are kept.

        Raises:
            TegotaeError: for more generations than there are to be.
            ValueError or KeyError: for arrays of another training.
        """
        progress = self._progress(run, arrays)
        generation = len(_fitness(points, run.seeds))
        if np.max(progress.generation) != generation:
            raise ValueError("curves and progress differ in length")
        if generation > self.stopping.generations:
            raise TegotaeError(
                f"generations is {self.stopping.generations}, and {generation} have been trained "
                "already; ask for as many or more, or choose another folder with --out"
            )
        return self._state(run, points, progress)

    def _progress(self, run: Run[Any], arrays: Arrays) -> Progress:
        """Return the progress of a state's arrays."""
        leaves, structure = jax.tree.flatten(self.start(run.experiment, run.seeds))
        stored = [arrays[f"leaf{i}"] for i in range(len(arrays))]
        for ours, theirs in zip(leaves, stored, strict=True):
            if (ours.shape, ours.dtype) != (theirs.shape, theirs.dtype):
                raise ValueError("shapes or types differ")
        return jax.tree.unflatten(structure, stored)

    def _state(
        self, run: Run[Any], points: Points, progress: Progress, new: Points = ()
    ) -> TrainingState:
        """Return the state after a generation: of each seed the mean of the best distribution."""
        experiment, seeds = run.experiment, run.seeds
        ended = self.stopping.reasons(_fitness(points, seeds))
        learned = tuple(
            LearnedController(
                experiment.controller,
                np.asarray(progress.best_weights[i]),
                {
                    "seed": seed,
                    "generations": int(progress.generation[i]),
                    "ended": ended[i],
                    "best_fitness": float(progress.best_fitness[i]),
                    "best_generation": int(progress.best_generation[i]),
                },
            )
            for i, seed in enumerate(seeds)
        )
        cot = float(mean_defined(np.array([point.cot_inverse for point in new])))
        measured = "" if math.isnan(cot) else f"CoT⁻¹ {cot:.3f} {experiment.cot_unit}".strip()
        report = (
            f"fitness {float(np.mean(progress.best_fitness)):+.3f}",
            measured,
            f"{sum(map(bool, ended))} of {len(seeds)} runs ended",
        )
        return TrainingState(
            int(np.max(progress.generation)),
            "  ".join(filter(None, report)),
            points,
            new,
            learned,
            {f"leaf{i}": leaf for i, leaf in enumerate(jax.tree.leaves(progress))},
        )

    def _searched(self, run: Run[Any]) -> TrainingState:
        """Search the gain σ of a pure V model."""
        gain, fitness = best_gain(run.experiment, self.workers)
        outcome = {"seed": run.seeds[0], "best_fitness": fitness, "ended": SEARCH}
        outcome |= {"generations": 0, "best_generation": 0}
        learned = LearnedController(run.experiment.controller, np.array([gain]), outcome)
        return TrainingState(1, f"fitness {fitness:+.3f}", learned=(learned,))


def _fitness(points: Sequence[CurvePoint], seeds: Sequence[int]) -> np.ndarray:
    """Return the fitness of the distributions' means, [generations, seeds]; NaN where a seed has
    ended."""
    generations = max((round(point.step) + 1 for point in points), default=0)
    fitness = np.full((generations, len(seeds)), np.nan)
    for point in points:
        fitness[round(point.step), seeds.index(point.seed)] = point.fitness
    return fitness


@partial(jit_in_one_module, static=(0, 1), level=_LEVEL)
def _initial_arrays(
    algorithm: Algorithm, controller: Controller, seeds: AnyArray, first: AnyArray | None
) -> Progress:
    def begin(seed: AnyArray) -> Progress:
        key_weights, key_search = jax.random.split(jax.random.key(seed))
        weights = controller.initial(key_weights) if first is None else jnp.asarray(first)
        return Progress(
            jnp.asarray(0),
            algorithm.start(key_search, weights),
            jnp.asarray(-jnp.inf),
            weights,
            jnp.zeros_like(weights),
            jnp.asarray(0),
        )

    return jax.vmap(begin)(seeds)


def _per_weight(std: jax.Array, centre: AnyArray) -> jax.Array:
    """Return standard deviations [seeds, n_weights] of a strategy that may have one for all
    weights.
    """
    return jnp.broadcast_to(std.reshape(*std.shape, *[1] * (centre.ndim - std.ndim)), centre.shape)


def _keys(progress: Progress, seeds: AnyArray) -> tuple[jax.Array, jax.Array]:
    """Return every seed's random keys of the generation, to ask and to tell with."""

    def keys(seed: AnyArray, generation: AnyArray) -> jax.Array:
        return jax.random.split(jax.random.fold_in(jax.random.key(seed), generation), 2)

    ask, tell = jnp.unstack(jax.vmap(keys)(seeds, progress.generation), axis=1)
    return ask, tell


@partial(jit_in_one_module, static=(0,), level=_LEVEL)
def _ask(
    algorithm: Algorithm, parameters: Parameters, progress: Progress, seeds: AnyArray
) -> tuple[SearchState, jax.Array]:
    """Return the optimiser's new state, and the candidates [seeds, population + 1, n_weights].

    The last candidate is the distribution's mean, by which the best distribution is chosen.
    """
    strategy = algorithm.strategy(progress.best_weights.shape[-1])
    key, _ = _keys(progress, seeds)
    samples, search = algorithm.of_seeds(lambda key, state: strategy.ask(key, state, parameters))(
        key, progress.search
    )
    return search, jnp.concatenate([samples, search.mean[:, None]], axis=1)


@partial(jit_in_one_module, static=(0,), level=_LEVEL)
def _tell(
    algorithm: Algorithm,
    parameters: Parameters,
    previous: Progress,
    search: SearchState,
    candidates: AnyArray,
    scores: Scores,
    seeds: AnyArray,
    going: AnyArray,
) -> tuple[Progress, Curves]:
    """Update the training with the scores; return its state and the generation's curves."""
    strategy = algorithm.strategy(previous.best_weights.shape[-1])
    _, key = _keys(previous, seeds)
    samples, centre = candidates[:, :-1], candidates[:, -1]
    fitness, of_centre = scores.fitness[:, :-1], scores.fitness[:, -1]
    search, _ = algorithm.of_seeds(lambda *of_seed: strategy.tell(*of_seed, parameters))(
        key, samples, -fitness, search
    )
    better = of_centre > previous.best_fitness
    pick = better[:, None]
    updated = Progress(
        previous.generation + 1,
        search,
        jnp.where(better, of_centre, previous.best_fitness),
        jnp.where(pick, centre, previous.best_weights),
        jnp.where(pick, _per_weight(previous.search.std, centre), previous.best_std),
        jnp.where(better, previous.generation, previous.best_generation),
    )
    sound = ~scores.failed[:, :-1]
    count = jnp.maximum(sound.sum(axis=1, dtype=fitness.dtype), 1.0)
    curves = Curves(
        of_centre,
        scores.cot_inverse[:, -1],
        jnp.where(sound, fitness, 0.0).sum(axis=1) / count,
        fitness.max(axis=1),
        1.0 - sound.mean(axis=1),
    )

    def where_going(new: jax.Array, old: jax.Array) -> jax.Array:
        return jnp.where(going.reshape(-1, *[1] * (new.ndim - 1)), new, old)

    updated = jax.tree.map(where_going, updated, previous)
    return updated, jax.tree.map(lambda x: jnp.where(going, x, jnp.nan), curves)
