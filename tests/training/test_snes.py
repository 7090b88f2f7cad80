"""SNES: its update re-derived in NumPy, and a climb."""

import jax
import jax.numpy as jnp
import numpy as np

from refusals import refused
from tegotae.training.algorithms import SNES
from tegotae.training.settings import learner

DIMENSIONS, POPULATION = 5, 10
START = jnp.linspace(-1.0, 1.0, DIMENSIONS)


def below_the_peak(samples: np.ndarray) -> np.ndarray:
    """A fitness whose best is at 2 in all weights."""
    return -((samples - 2.0) ** 2).sum(axis=1)


def generation(settings: SNES, state, key):
    """The samples of a generation, and the state after it."""
    strategy, parameters = settings.strategy(DIMENSIONS), settings.parameters(DIMENSIONS)
    samples, state = strategy.ask(key, state, parameters)
    fitness = below_the_peak(np.asarray(samples, float))
    updated, _ = strategy.tell(key, samples, -jnp.asarray(fitness), state, parameters)
    return np.asarray(samples, float), fitness, updated


def test_a_generation_moves_mean_and_deviations_as_its_formula_says():
    settings = SNES(population=POPULATION, std=0.4)
    begun = settings.start(jax.random.key(1), START)
    samples, fitness, state = generation(settings, begun, jax.random.key(2))
    rank = np.argsort(np.argsort(-fitness)) + 1.0
    utility = np.maximum(0.0, np.log(POPULATION / 2 + 1) - np.log(rank))
    utility = utility / utility.sum() - 1.0 / POPULATION
    z = (samples - np.asarray(START)) / 0.4
    rate = (3.0 + np.log(DIMENSIONS)) / (5.0 * np.sqrt(DIMENSIONS))
    mean = np.asarray(START) + 0.4 * utility @ z
    std = 0.4 * np.exp(0.5 * rate * utility @ (z**2 - 1.0))
    np.testing.assert_allclose(state.mean, mean, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(state.std, std, rtol=1e-5)


def test_it_climbs_without_a_learning_rate():
    settings = SNES(population=20, std=0.4)
    state = settings.start(jax.random.key(1), START)
    for number in range(60):
        *_, state = generation(settings, state, jax.random.key(number))
    assert below_the_peak(np.asarray(state.mean)[None])[0] > -0.01


def test_it_is_trained_with_by_its_name_and_refuses_no_population():
    assert learner("snes") is SNES
    refused("population is 1; it must be a whole number of at le", SNES, population=1)
