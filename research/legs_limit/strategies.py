"""Many evolution strategies at once: the candidates of all share a rollout a generation."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.training.algorithms import CMAES

KEPT_EVERY = 20
"""Generations after which a search is written down."""


class Found(NamedTuple):
    """Results of the searches, [starts] first."""

    x: np.ndarray
    """The vector of least loss, [starts, size]."""
    loss: np.ndarray
    """Its loss, [starts]."""
    centre: np.ndarray
    """The middle of the distribution after the last generation, [starts, size]."""
    history: np.ndarray
    """The least loss up to every generation, [generations, starts]."""
    typical: np.ndarray
    """The median loss of every generation, [generations, starts]."""


def load(file: Path) -> Found:
    """Read the file of a search."""
    with np.load(file) as record:
        return Found(*(record[field] for field in Found._fields))


def search(
    losses: Callable[[np.ndarray, int], np.ndarray],
    start: np.ndarray,
    *,
    std: float,
    population: int,
    generations: int,
    seed: int,
    checkpoint: Path,
    progress: Callable[[int, np.ndarray], None] = lambda *_: None,
) -> Found:
    """Search with one strategy (CMA-ES) per start, all in one rollout per generation.

    Args:
        losses: of vectors [starts * population, size] in a generation; the candidates of a start
            are next to each other.
        start: vectors [starts, size].
        std: first deviation.
        population: candidates of a generation of a start.
        generations: how many.
        seed: of the draws.
        checkpoint: file from which it goes on, and where it is written every 20 generations.
        progress: called with the generation and the least losses.
    """
    starts, size = start.shape
    keys = jax.random.split(jax.random.key(seed), starts)
    begin, ask, tell = _programs(CMAES(population=population, std=std), size)
    state = begin(keys, jnp.asarray(start, "float32"))
    leaves, tree = jax.tree.flatten(state)
    best, lowest = np.array(start, float), np.full(starts, np.inf)
    history: list[np.ndarray] = []
    typical: list[np.ndarray] = []
    if checkpoint.exists():
        with np.load(checkpoint) as record:
            state = jax.tree.unflatten(tree, [record[f"state{k}"] for k in range(len(leaves))])
            best, lowest = record["x"].copy(), record["loss"].copy()
            history, typical = list(record["history"]), list(record["typical"])

    def result() -> Found:
        centre = np.asarray(state.mean, float)
        return Found(best, lowest, centre, np.array(history), np.array(typical))

    for number in range(len(history), generations):
        x, state = ask(keys, number, state)
        samples = np.array(x, float)
        if number == 0:
            samples[:, 0] = start
        loss = losses(samples.reshape(-1, size), number).reshape(starts, population)
        state = tell(keys, jnp.asarray(samples, "float32"), jnp.asarray(loss, "float32"), state)
        k, rows = loss.argmin(axis=1), np.arange(starts)
        better = rows[loss[rows, k] < lowest]
        best[better], lowest[better] = samples[better, k[better]], loss[better, k[better]]
        history.append(lowest.copy())
        typical.append(np.median(loss, axis=1))
        progress(number + 1, lowest)
        if (number + 1) % KEPT_EVERY == 0 or number + 1 == generations:
            states = {f"state{k}": leaf for k, leaf in enumerate(jax.tree.leaves(state))}
            np.savez(checkpoint, **result()._asdict(), **states)
    return result()


@cache
def _programs(algorithm: CMAES, size: int) -> tuple[Callable[..., Any], ...]:
    """Return the compiled steps of many strategies, shared by searches of as many numbers."""
    strategy, settings = algorithm.strategy(size), algorithm.parameters(size)

    @jax.jit
    def begin(keys, mean):
        return jax.lax.map(lambda a: strategy.init(*a, settings), (keys, mean))

    @jax.jit
    def ask(keys, number, state):
        keys_of_step = jax.vmap(lambda key: jax.random.fold_in(key, number))(keys)
        return jax.lax.map(lambda a: strategy.ask(*a, settings), (keys_of_step, state))

    @jax.jit
    def tell(keys, x, loss, state):
        return jax.lax.map(lambda a: strategy.tell(*a, settings)[0], (keys, x, loss, state))

    return begin, ask, tell
