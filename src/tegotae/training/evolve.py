"""Generations of an evolution, and when they end."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.parts._shapes import AnyArray
from tegotae.parts.controller import Controller
from tegotae.systems.descriptions import check_kept
from tegotae.training.algorithms import Algorithm
from tegotae.training.algorithms.base import Parameters, SearchState
from tegotae.training.evaluator import Evaluator, Generation, Scores

_NEVER = 2**31

RUNNING, PLATEAU, CAP = "", "plateau", "cap"
"""Why a run ended; the first if it has not."""

SEARCH = "search"
"""The end of what is not trained but searched for: a pure V model's σ."""


@dataclass(frozen=True, kw_only=True)
class Stopping:
    """Stop a run once its fitness is on a plateau, or at a cap.

    With b(g) the best fitness of the distribution's mean over the first g generations, a run is on
    a plateau after g generations if

        b(g) - b(g - ⌈share · g⌉) <= tolerance   and   g >= least.

    The wait grows with the training, so that a run which found something late is given its time
    again. A jump that comes after a longer wait than this is missed. Each run is decided alone.

    Args:
        generations: the cap: no run has more generations.
        least: generations before which no plateau is seen.
        share: of the training so far, in which nothing may be gained.
        tolerance: what counts as nothing, in units of the fitness [m/J].

    Raises:
        TegotaeError: for a count below one, a share that is not between 0 and 1, or a negative
            tolerance.

    Example:
        >>> rule = Stopping(generations=100, least=10, share=0.5, tolerance=0.01)
        >>> [rule.reason(np.minimum(np.arange(n), 8.0)) for n in (10, 17, 18)]
        ['', '', 'plateau']
    """

    generations: int = 480
    least: int = 240
    share: float = 0.5
    tolerance: float = 0.02

    def __post_init__(self) -> None:
        require_count("generations", self.generations)
        require_count("least", self.least)
        require_finite("share", self.share, above=0.0)
        require_finite("tolerance", self.tolerance, least=0.0)
        if self.share >= 1.0:
            raise TegotaeError(
                f"share is {self.share:g}; it must be less than 1: the part of a training that "
                "gives no gain"
            )

    @classmethod
    def after(cls, generations: int) -> Stopping:
        """Exactly so many generations, plateau or not."""
        return cls(generations=generations, least=_NEVER)

    @property
    def rule(self) -> dict[str, float]:
        """All but the cap: a training can go on under a higher cap, but not under another rule."""
        return {"least": self.least, "share": self.share, "tolerance": self.tolerance}

    def reason(self, fitness: np.ndarray) -> str:
        """Why a run ends after these generations, or the empty string if it goes on.

        Args:
            fitness: of the distribution's mean, generation by generation, shape [generations].
        """
        done = len(fitness)
        before = done - math.ceil(self.share * done)
        if done >= self.least and before >= 1:
            gain = np.max(fitness) - np.max(fitness[:before])
            if gain <= self.tolerance:
                return PLATEAU
        return CAP if done >= self.generations else RUNNING

    def reasons(self, curves: np.ndarray) -> list[str]:
        """The same for runs side by side; a run's curve ends in NaN where it has ended.

        Args:
            curves: shape [generations, runs].
        """
        curves = np.asarray(curves, float)
        return [self.reason(run[~np.isnan(run)]) for run in curves.T]


_QUICKLY = {"xla_backend_optimization_level": 0}
"""Compiler options of programs that run once a generation: they take longer to compile well than
they ever run."""


class Progress(NamedTuple):
    """Where a training is, after some generations; arrays with one entry per seed.

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


def start(algorithm: Algorithm, controller: Controller, seeds: Sequence[int]) -> Progress:
    """Every seed's own random weights.

    A seed's run does not depend on which others go with it. Warns of a part that could not be saved
    with what it learns.

    Args:
        algorithm: how is learned.
        controller: whose weights.
        seeds: one training each.

    Raises:
        TegotaeError: without seeds.
    """
    if not seeds:
        raise TegotaeError("no seeds to train; give at least one")
    try:
        check_kept((algorithm, controller))
    except TegotaeError as error:
        warnings.warn(f"what is learned could not be saved: {error}", stacklevel=2)

    return _begun(algorithm, controller, np.asarray(seeds, "int32"))


@partial(jax.jit, static_argnums=(0, 1), compiler_options=_QUICKLY)
def _begun(algorithm: Algorithm, controller: Controller, seeds: jax.Array) -> Progress:
    def one(seed: jax.Array) -> Progress:
        key_weights, key_search = jax.random.split(jax.random.key(seed))
        weights = controller.initial(key_weights)
        return Progress(
            jnp.asarray(0),
            algorithm.start(key_search, weights),
            jnp.asarray(-jnp.inf),
            weights,
            jnp.zeros_like(weights),
            jnp.asarray(0),
        )

    return jax.vmap(one)(seeds)


def evolve(
    algorithm: Algorithm,
    evaluator: Evaluator,
    progress: Progress,
    seeds: Sequence[int],
    stopping: Stopping,
    *,
    fitness: ArrayLike | None = None,
) -> Iterator[tuple[Progress, Curves]]:
    """Train on, one generation at a time, until every seed has ended.

    Args:
        algorithm: how is learned.
        evaluator: who says how good candidates are.
        progress: from `start`, or where an earlier training stopped.
        seeds: the seeds that `progress` was started with.
        stopping: when a seed ends.
        fitness: of an earlier training its `Curves.centre_fitness`, [generations, seeds].

    Yields:
        the new progress and the generation's curves (NumPy arrays).

    Raises:
        TegotaeError: for the fitness of another number of generations.
    """
    parameters = algorithm.parameters(progress.best_weights.shape[-1])
    seen = [] if fitness is None else list(np.asarray(fitness))
    if len(seen) != np.max(progress.generation):
        raise TegotaeError(
            f"the fitness of {len(seen)} generations was given for a training of "
            f"{np.max(progress.generation)}"
        )
    of_seeds = np.asarray(seeds, "int32")
    going = _going(stopping, seen, len(seeds))
    while going.any():
        # As host arrays the start and later progress are of the same type: one compilation.
        progress = jax.tree.map(np.asarray, progress)
        asked, everyone = _ask(algorithm.program, parameters, progress, of_seeds)
        scores = evaluator.evaluate(
            np.asarray(everyone), Generation(tuple(seeds), going, len(seen))
        )
        arguments = algorithm.program, parameters, progress, asked, np.asarray(everyone), scores
        progress, curves = _tell(*arguments, of_seeds, going)
        curves = jax.tree.map(np.asarray, curves)
        seen.append(curves.centre_fitness)
        yield progress, curves
        going = _going(stopping, seen, len(seeds))


def _going(stopping: Stopping, fitness: list[np.ndarray], n_seeds: int) -> np.ndarray:
    """Which seeds go on, [seeds]."""
    curves = np.array(fitness).reshape(len(fitness), n_seeds)
    return np.array([reason == RUNNING for reason in stopping.reasons(curves)])


def _per_weight(std: jax.Array, centre: jax.Array) -> jax.Array:
    """Standard deviations [seeds, n_weights], of a strategy that may have one for all weights."""
    return jnp.broadcast_to(std.reshape(*std.shape, *[1] * (centre.ndim - std.ndim)), centre.shape)


def _keys(progress: Progress, seeds: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Of every seed the generation's keys, to ask and to tell with."""

    def keys(seed: jax.Array, generation: AnyArray) -> jax.Array:
        return jax.random.split(jax.random.fold_in(jax.random.key(seed), generation), 2)

    ask, tell = jnp.unstack(jax.vmap(keys)(seeds, progress.generation), axis=1)
    return ask, tell


@partial(jax.jit, static_argnums=0, compiler_options=_QUICKLY)
def _ask(
    algorithm: Algorithm, parameters: Parameters, progress: Progress, seeds: jax.Array
) -> tuple[SearchState, jax.Array]:
    """The optimiser's new state, and the candidates [seeds, population + 1, n_weights].

    The last candidate is the distribution's mean, by which the best distribution is chosen.
    """
    strategy = algorithm.strategy(progress.best_weights.shape[-1])
    key, _ = _keys(progress, seeds)
    samples, search = algorithm.of_seeds(lambda key, state: strategy.ask(key, state, parameters))(
        key, progress.search
    )
    return search, jnp.concatenate([samples, search.mean[:, None]], axis=1)


@partial(jax.jit, static_argnums=0, compiler_options=_QUICKLY)
def _tell(
    algorithm: Algorithm,
    parameters: Parameters,
    before: Progress,
    search: SearchState,
    everyone: jax.Array,
    scores: Scores,
    seeds: jax.Array,
    going: jax.Array,
) -> tuple[Progress, Curves]:
    """Where the training is once the optimiser knows the scores, and the generation's curves."""
    strategy = algorithm.strategy(before.best_weights.shape[-1])
    _, key = _keys(before, seeds)
    samples, centre = everyone[:, :-1], everyone[:, -1]
    fitness, own = scores.fitness[:, :-1], scores.fitness[:, -1]
    search, _ = algorithm.of_seeds(lambda *of_seed: strategy.tell(*of_seed, parameters))(
        key, samples, -fitness, search
    )
    better = own > before.best_fitness
    pick = better[:, None]
    after = Progress(
        before.generation + 1,
        search,
        jnp.where(better, own, before.best_fitness),
        jnp.where(pick, centre, before.best_weights),
        jnp.where(pick, _per_weight(before.search.std, centre), before.best_std),
        jnp.where(better, before.generation, before.best_generation),
    )
    sound = ~scores.failed[:, :-1]
    count = jnp.maximum(sound.sum(axis=1, dtype=fitness.dtype), 1.0)
    curves = Curves(
        own,
        scores.cot_inverse[:, -1],
        jnp.where(sound, fitness, 0.0).sum(axis=1) / count,
        fitness.max(axis=1),
        1.0 - sound.mean(axis=1),
    )

    def where_going(new: jax.Array, old: jax.Array) -> jax.Array:
        return jnp.where(going.reshape(-1, *[1] * (new.ndim - 1)), new, old)

    after = jax.tree.map(where_going, after, before)
    return after, jax.tree.map(lambda x: jnp.where(going, x, jnp.nan), curves)
