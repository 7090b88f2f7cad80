"""Who says how good candidates are: all of a training that knows where they were tried."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.devices import on_every_device
from tegotae.measures.objectives.objective import EpisodeSummary, Objective, scores
from tegotae.parts.bodies import Body
from tegotae.simulation.loop import check_senses
from tegotae.simulation.rollout import Engine
from tegotae.simulation.world import Scenario
from tegotae.simulation.world.randomization import Randomization
from tegotae.systems.experiment import Experiment


class Scores(NamedTuple):
    """How good candidates are; arrays [seeds, candidates]. What it says of ended seeds is void."""

    fitness: Any
    """The larger, the better."""
    cot_inverse: Any
    """CoT⁻¹ [m/J]; NaN where it is not measured."""
    failed: Any
    """Whether the episode failed."""


class Generation(NamedTuple):
    """For whom candidates are evaluated, and when."""

    seeds: tuple[int, ...]
    """The runs."""
    going: np.ndarray
    """Which of them have not ended, [seeds]."""
    generation: int | None = None
    """Its number. The last candidate of every seed is then the centre of its distribution; without
    a number all are of one kind, and meet the same episodes."""

    @classmethod
    def alike(cls) -> Generation:
        """Of one seed's candidates that all meet the same episodes."""
        return cls((0,), np.array([True]))


class Evaluator(ABC):
    """Scores candidates' weights by episodes, wherever these take place; a context manager.

    The optimiser's loop (`tegotae.training.evolve`) hands it arrays and gets arrays.
    """

    @abstractmethod
    def evaluate(self, candidates: np.ndarray, who: Generation) -> Scores:
        """The verdict on every candidate of the seeds that are going.

        Args:
            candidates: weights, [seeds, candidates, n_weights].
            who: the seeds.
        """

    @property
    def program(self) -> tuple[Any, ...]:
        """What is compiled for it; hashable."""
        return ()

    def close(self) -> None:  # noqa: B027 - optional
        """Give back what it holds, such as worker processes."""

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True, eq=False)
class EngineEvaluator(Evaluator):
    """Scores by episodes of this package's engine: all candidates in one compiled program.

    Args:
        engine: what rolls the episodes out.
        fitness: by what measure; what of an episode counts is the engine's summary.
        varied: body and scenario, and in what the episodes differ.
        episodes: how many episodes each candidate has, on average; the evaluation set has at least
            `LEAST_EVALUATION_SET`.

    Raises:
        TegotaeError: for a body that does not go with the controller or the control period.
    """

    engine: Engine
    fitness: Objective
    varied: Randomization
    episodes: int = 1

    def __post_init__(self) -> None:
        check_senses(self.engine.controller, self.varied.body)
        self.varied.body.check_tick(self.engine.timing.tick_s)

    @property
    def program(self) -> tuple[Engine, Objective, int]:
        """What is compiled: settings of the fitness are data."""
        fitness = self.fitness.program
        return (
            dataclasses.replace(self.engine, summary=EpisodeSummary(fitness)),
            fitness,
            self.episodes,
        )

    def evaluate(self, candidates: np.ndarray, who: Generation) -> Scores:
        """The verdict on every candidate; ended seeds cost nothing, but for a block's rest."""
        seeds, per_seed, _ = candidates.shape
        repeats = self.varied.repeats(self.episodes)
        evaluation_episodes = repeats * self.episodes
        if who.generation is None:
            first = 0  # of the candidates that meet the evaluation set
            episode = self.varied.evaluation_set(seeds * per_seed, evaluation_episodes)
        else:
            first = per_seed - 1
            which = who.generation, first, self.episodes, evaluation_episodes
            episode = self.varied.generation(who.seeds, *which)
        # Whoever meets the evaluation set does so as several candidates.
        again = np.repeat(candidates[:, first:], repeats, axis=1)
        candidates = np.concatenate([candidates[:, :first], again], axis=1)
        body = jax.tree.map(lambda x: jnp.asarray(x, "float32"), self.varied.body)
        episode = jax.tree.map(np.float32, episode)
        given = candidates, who.going, episode, body, self.fitness.data
        outcome = _evaluated(*self.program, *given)

        def merged(name: str) -> np.ndarray:
            x = np.asarray(outcome[name])
            if repeats == 1:
                return x
            parts = x[:, first:].reshape(seeds, -1, repeats)
            one = parts.any(axis=-1) if name == "failed" else parts.mean(axis=-1)
            return np.concatenate([x[:, :first], one], axis=1)

        return Scores(*map(merged, Scores._fields))


def evaluator_of(experiment: Any, workers: int | None = None) -> Evaluator:
    """Who says in a training how good weights are.

    Args:
        experiment: an `Experiment`, or one on an environment.
        workers: worker processes of an environment, one a core by default; the engine needs none.
    """
    if not isinstance(experiment, Experiment):
        return experiment.evaluator(workers)
    varied = Randomization(experiment.conditions, experiment.body, experiment.scenario)
    engine = experiment.system.engine()
    return EngineEvaluator(engine, experiment.measure, varied, experiment.episodes)


@partial(jax.jit, static_argnums=(0, 1, 2))
def _evaluated(
    engine: Engine,
    fitness: Objective,
    episodes: int,
    candidates: jax.Array,
    going: jax.Array,
    scenario: Scenario,
    body: Body,
    data: Any,
) -> dict[str, jax.Array]:
    n_seeds, per_seed, n_weights = candidates.shape
    per_seed *= episodes
    lanes = n_seeds * per_seed
    # Seeds that go on come first: blocks of lanes of ended ones cost nothing.
    order = jnp.argsort(~going, stable=True)
    everyone = on_every_device(candidates)[order].reshape(-1, n_weights).T
    if episodes > 1:
        everyone = jnp.repeat(everyone, episodes, axis=1)

    def of_lanes(x: jax.Array) -> jax.Array:
        """One a lane, in the order of the seeds; what is the same for all is so already."""
        if jnp.ndim(x) == 0 or x.shape[-1] == 1:
            return jnp.broadcast_to(x, (*x.shape[:-1], lanes))
        by_seed = x.reshape(*x.shape[:-1], n_seeds, per_seed)
        return by_seed[..., order, :].reshape(*x.shape[:-1], lanes)

    each = jax.tree.map(of_lanes, scenario)
    wanted = going.sum() * per_seed
    outcome = scores(fitness, engine.trace(everyone, each, body, wanted), data)
    back = jnp.argsort(order)
    return {
        name: _together(name, x.reshape(n_seeds, -1, episodes)[back])
        for name, x in on_every_device(outcome).items()
    }


def _together(name: str, episodes: jax.Array) -> jax.Array:
    """What a candidate's episodes make together: their mean; it has failed if one of them has."""
    if episodes.shape[-1] == 1:
        return episodes[..., 0]
    return jnp.any(episodes, axis=-1) if name == "failed" else jnp.mean(episodes, axis=-1)
