"""Evolution of a model's weights: all its seeds, all their episodes, in one compiled program."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller
from tegotae.devices import on_every_device
from tegotae.errors import TegotaeError
from tegotae.integrators import Integrator, PredictorCorrector
from tegotae.rollout import Engine, Scenario, Timing, check_senses
from tegotae.training.algorithms import PGPE, Algorithm
from tegotae.training.fitness import EPISODE, Fitness
from tegotae.training.objective import Objective
from tegotae.training.stopping import RUNNING, Stopping


@dataclass(frozen=True, kw_only=True)
class Training:
    """What is trained and how: the static part of the compiled program.

    Args:
        controller: what is trained.
        algorithm: how.
        fitness: by what measure.
        timing: the episode.
        integrator: how it is advanced.

    Raises:
        TegotaeError: for an episode too short for its fitness.
    """

    controller: Controller
    algorithm: Algorithm = field(default_factory=PGPE)
    fitness: Objective = field(default_factory=Fitness)
    timing: Timing = EPISODE
    integrator: Integrator = field(default_factory=PredictorCorrector)

    def __post_init__(self) -> None:
        self.fitness.check(self.timing)

    @property
    def engine(self) -> Engine:
        """The engine that rolls out the episodes."""
        return Engine(
            controller=self.controller,
            integrator=self.integrator,
            timing=self.timing,
            summary=self.fitness.judged,
        )

    @property
    def program(self) -> Training:
        """The part that is compiled: settings of algorithm and fitness are data."""
        return dataclasses.replace(
            self,
            algorithm=self.algorithm.program,
            fitness=self.fitness.program,
        )


class Progress(NamedTuple):
    """Where a training is, after some generations; arrays with one entry per seed.

    Seeds that have ended stand still.
    """

    generation: Any
    """Generations done."""
    search: Any
    """The optimiser's state."""
    best_fitness: Any
    """Fitness of the best distribution seen."""
    best_weights: Any
    """Mean of that distribution, shape [seeds, n_weights]."""
    best_std: Any
    """Its standard deviation, shape [seeds, n_weights]."""
    best_generation: Any
    """The generation in which it was seen."""


class Curves(NamedTuple):
    """One generation's learning curves, each of shape [seeds]; NaN where a seed has ended."""

    centre_fitness: Any
    """Fitness of the distribution's mean."""
    centre_cot_inverse: Any
    """CoT⁻¹ of the distribution's mean [m/J]."""
    mean_fitness: Any
    """Mean fitness of the samples that did not fail."""
    best_fitness: Any
    """Fitness of the best sample."""
    failed_share: Any
    """Share of the samples that failed."""


def start(training: Training, seeds: Sequence[int]) -> Progress:
    """Every seed's own random weights.

    A seed's run does not depend on which others go with it.
    """
    if not seeds:
        raise TegotaeError("no seeds to train; give at least one")

    key_search, weights = _initial(training.controller, jnp.asarray(seeds))

    def one(key: jax.Array, weights: jax.Array) -> Progress:
        search = training.algorithm.start(key, weights)
        return Progress(
            jnp.asarray(0),
            search,
            jnp.asarray(-jnp.inf),
            weights,
            jnp.zeros_like(weights),
            jnp.asarray(0),
        )

    return jax.vmap(one)(key_search, weights)


@partial(jax.jit, static_argnums=0)
def _initial(controller: Controller, seeds: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Every seed's key for the search, and its first weights [seeds, n_weights]."""

    def one(seed: jax.Array) -> tuple[jax.Array, jax.Array]:
        key_weights, key_search = jax.random.split(jax.random.key(seed))
        return key_search, controller.initial(key_weights)

    return jax.vmap(one)(seeds)


def evolve(
    training: Training,
    progress: Progress,
    seeds: Sequence[int],
    omega: float | None,
    stopping: Stopping,
    body: Body | None = None,
    *,
    scenario: Scenario | None = None,
    fitness: Any = None,
) -> Iterator[tuple[Progress, Curves]]:
    """Train on, one generation at a time, until every seed has ended.

    Args:
        training: what and how.
        progress: from `start`, or where an earlier training stopped.
        seeds: the seeds that `progress` was started with.
        omega: prescribed frequency ω_t [rad/s]; None without an oscillator.
        stopping: when a seed ends.
        body: the body; the paper's hopper by default.
        scenario: an episode of numbers, or of arrays [limbs, 1]; the standard release by default,
            at `omega` in any case.
        fitness: of an earlier training its `Curves.centre_fitness`, [generations, seeds].

    Yields:
        the new progress and the generation's curves (NumPy arrays).
    """
    driven: Body = Hopper() if body is None else body
    check_senses(training.controller, driven)
    driven.check_tick(training.timing.tick_s)
    driven = jax.tree.map(lambda x: jnp.asarray(x, "float32"), driven)
    parameters = training.algorithm.parameters(training.controller.n_weights)
    episode = Scenario.of(omega)
    if scenario is not None:
        episode = scenario._replace(omega=episode.omega)
    episode = jax.tree.map(np.float32, episode)
    seen = [] if fitness is None else list(np.asarray(fitness))
    if len(seen) != np.max(progress.generation):
        raise TegotaeError(
            f"the fitness of {len(seen)} generations was given for a training of "
            f"{np.max(progress.generation)}"
        )
    going = _going(stopping, seen, len(seeds))
    while going.any():
        # As host arrays the start and later progress are of the same type: one compilation.
        progress = jax.tree.map(np.asarray, progress)
        progress, curves = _generation(
            training.program,
            parameters,
            training.fitness.data,
            progress,
            jnp.asarray(seeds),
            going,
            episode,
            driven,
        )
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


@partial(jax.jit, static_argnums=0)
def _generation(
    training: Training,
    parameters: Any,
    data: Any,
    progress: Progress,
    seeds: jax.Array,
    going: jax.Array,
    scenario: Scenario,
    body: Body,
) -> tuple[Progress, Curves]:
    n_weights = training.controller.n_weights
    strategy = training.algorithm.strategy(n_weights)
    before = progress

    def keys(seed: jax.Array, generation: jax.Array) -> jax.Array:
        return jax.random.split(jax.random.fold_in(jax.random.key(seed), generation), 2)

    ask_key, tell_key = jnp.unstack(jax.vmap(keys)(seeds, progress.generation), axis=1)
    of_seeds = training.algorithm.of_seeds
    samples, search = of_seeds(lambda key, state: strategy.ask(key, state, parameters))(
        ask_key, progress.search
    )
    centre = search.mean
    # One more lane per seed: the distribution's mean, by which the best distribution is chosen.
    everyone = on_every_device(jnp.concatenate([samples, centre[:, None]], axis=1))
    n_seeds, per_seed = everyone.shape[:2]
    lanes = n_seeds * per_seed
    # Seeds that go on come first: blocks of lanes of ended ones cost nothing.
    order = jnp.argsort(~going, stable=True)
    everyone = everyone[order].reshape(lanes, n_weights).T
    each = jax.tree.map(lambda x: jnp.broadcast_to(x, (*x.shape[:-1], lanes)), scenario)
    wanted = going.sum() * per_seed
    outcome = training.fitness.weigh(training.engine.trace(everyone, each, body, wanted), data)
    back = jnp.argsort(order)
    outcome = {
        name: x.reshape(n_seeds, per_seed)[back] for name, x in on_every_device(outcome).items()
    }
    fitness, own = outcome["fitness"][:, :-1], outcome["fitness"][:, -1]

    search, _ = of_seeds(lambda *of_seed: strategy.tell(*of_seed, parameters))(
        tell_key, samples, -fitness, search
    )
    better = own > progress.best_fitness
    pick = better[:, None]
    progress = Progress(
        progress.generation + 1,
        search,
        jnp.where(better, own, progress.best_fitness),
        jnp.where(pick, centre, progress.best_weights),
        jnp.where(pick, _per_weight(progress.search.std, centre), progress.best_std),
        jnp.where(better, progress.generation, progress.best_generation),
    )
    sound = ~outcome["failed"][:, :-1]
    count = jnp.maximum(sound.sum(axis=1, dtype=fitness.dtype), 1.0)
    curves = Curves(
        own,
        outcome["cot_inverse"][:, -1],
        jnp.where(sound, fitness, 0.0).sum(axis=1) / count,
        fitness.max(axis=1),
        1.0 - sound.mean(axis=1),
    )

    def where_going(new: jax.Array, old: jax.Array) -> jax.Array:
        return jnp.where(going.reshape(-1, *[1] * (new.ndim - 1)), new, old)

    progress = jax.tree.map(where_going, progress, before)
    return progress, jax.tree.map(lambda x: jnp.where(going, x, jnp.nan), curves)
