"""Searches of a study by a population: each goes on from its last whole generation."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.files import write_atomically
from tegotae.training.algorithms import Algorithm


def search(
    place: Path,
    algorithm: Algorithm,
    start: np.ndarray,
    generations: int,
    fitness: Callable[[np.ndarray, int], np.ndarray],
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Maximise a fitness, from where an earlier search of this place was stopped.

    Args:
        place: file .npz of the state after each generation.
        algorithm: with its population.
        start: first mean, [n].
        generations: how many in all.
        fitness: function of candidates [population, n] and the generation, [population].
        seed: of the search.

    Returns:
        The last mean, [n], and the fitness of all candidates, [generations, population].
    """
    key, evolution = jax.random.key(seed), algorithm.strategy(len(start))
    parameters = algorithm.parameters(len(start))
    state = algorithm.start(key, jnp.asarray(start, "float32"))
    scores: list[np.ndarray] = []
    if place.exists():
        with np.load(place, allow_pickle=False) as kept:
            scores = [*kept["scores"]]
            leaves = [kept[f"state_{i}"] for i in range(len(kept.files) - 1)]
        state = jax.tree.unflatten(jax.tree.structure(state), leaves)
    for generation in range(len(scores), generations):
        keys = jax.random.split(jax.random.fold_in(key, generation))
        candidates, state = evolution.ask(keys[0], state, parameters)
        scores.append(np.asarray(fitness(np.asarray(candidates, float), generation)))
        state, _ = evolution.tell(keys[1], candidates, jnp.asarray(-scores[-1]), state, parameters)
        print(f"{place.stem}: {generation}, mean {scores[-1].mean():.3f}", flush=True)
        arrays: dict[str, Any] = {"scores": np.array(scores)}
        arrays |= {f"state_{i}": np.asarray(x) for i, x in enumerate(jax.tree.leaves(state))}
        content = io.BytesIO()
        np.savez(content, **arrays)
        write_atomically(place, content.getvalue())
    return np.asarray(evolution.get_mean(state), float), np.array(scores)
