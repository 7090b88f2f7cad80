"""PGPE: its update re-derived in NumPy, and the training of several seeds at once."""

import dataclasses
import math
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from evosax.algorithms import PGPE as EvosaxPGPE  # noqa: N811
from evosax.core.optimizer import clipup
from scipy.stats import rankdata

from refusals import refused
from tegotae import TegotaeError, Timing
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.fields import replace
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.systems.system import System
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run

DIMENSIONS = 5
SETTINGS = PGPE(
    population=12, std=0.4, std_lr=0.3, std_max_change=0.2, learning_rate=0.15, max_speed=0.3
)


class ByHand:
    """PGPE in plain NumPy and float64, climbing the fitness."""

    def __init__(self, settings: PGPE, mean: np.ndarray) -> None:
        self.settings, self.mean = settings, np.array(mean, "float64")
        self.std = np.full_like(self.mean, settings.std)
        self.velocity = np.zeros_like(self.mean)
        self.std_was_clipped = self.speed_was_clipped = False

    def tell(self, samples: np.ndarray, fitness: np.ndarray) -> None:
        s, n = self.settings, len(samples)
        # Centred ranks: -1/2 for the worst, 1/2 for the best; equals share their mean rank.
        rank = (rankdata(fitness, method="average") - 1.0) / (n - 1.0) - 0.5
        plus, minus = rank[: n // 2], rank[n // 2 :]
        epsilon = samples[: n // 2] - self.mean
        to_mean = ((plus - minus)[:, None] * epsilon).sum(axis=0) / n
        push = (plus + minus - 2.0 * rank.mean())[:, None]
        to_std = (push * (epsilon**2 - self.std**2) / self.std).sum(axis=0) / n
        # ClipUp: a step of fixed length along the gradient, with momentum, and a speed limit.
        length = np.linalg.norm(to_mean)
        step = s.learning_rate * to_mean / length if length > 0 else np.zeros_like(to_mean)
        self.velocity = s.momentum * self.velocity + step
        speed = np.linalg.norm(self.velocity)
        if speed > s.max_speed:
            self.velocity *= s.max_speed / speed
            self.speed_was_clipped = True
        self.mean = self.mean + self.velocity
        wished = self.std + s.std_lr * to_std
        low, high = (1.0 - s.std_max_change) * self.std, (1.0 + s.std_max_change) * self.std
        self.std_was_clipped |= bool(((wished < low) | (wished > high)).any())
        self.std = np.clip(wished, low, high)


def first_mean() -> np.ndarray:
    return np.random.default_rng(0).normal(size=DIMENSIONS).astype("float32")


def generations(settings: PGPE, fitness_of, count: int):
    """Run both implementations side by side on the same samples; yields after each generation."""
    strategy, parameters = settings.strategy(DIMENSIONS), settings.parameters(DIMENSIONS)
    state = settings.start(jax.random.key(0), jnp.asarray(first_mean()))
    by_hand = ByHand(settings, first_mean())
    for generation in range(count):
        key = jax.random.fold_in(jax.random.key(0), generation)
        samples, state = strategy.ask(key, state, parameters)
        fitness = np.asarray(fitness_of(np.asarray(samples)), "float32")
        state, _ = strategy.tell(key, samples, jnp.asarray(-fitness), state, parameters)
        by_hand.tell(np.asarray(samples, "float64"), fitness)
        yield samples, state, by_hand


def peak_at_one(samples: np.ndarray) -> np.ndarray:
    return -((samples - 1.0) ** 2).sum(axis=1)


def with_ties(samples: np.ndarray) -> np.ndarray:
    return np.round(peak_at_one(samples))


def assert_agree(state, by_hand: ByHand) -> None:
    np.testing.assert_allclose(state.mean, by_hand.mean, atol=2e-5)
    np.testing.assert_allclose(state.std, by_hand.std, rtol=2e-5)


@pytest.mark.parametrize("fitness_of", [peak_at_one, with_ties])
def test_the_update_is_that_of_the_equations(fitness_of):
    tied = False
    for samples, state, by_hand in generations(SETTINGS, fitness_of, 25):
        assert_agree(state, by_hand)
        fitness = fitness_of(np.asarray(samples))
        tied |= len(set(fitness)) < len(fitness)
    assert by_hand.speed_was_clipped
    assert tied == (fitness_of is with_ties)


def test_a_standard_deviation_changes_by_at_most_a_fifth():
    eager = PGPE(population=12, std=0.4, std_lr=50.0, std_max_change=0.2)
    initial = np.full(DIMENSIONS, 0.4)
    for _, state, by_hand in generations(eager, peak_at_one, 10):
        ratio = np.asarray(state.std) / initial
        assert (ratio > 0.8 - 1e-5).all()
        assert (ratio < 1.2 + 1e-5).all()
        initial = np.asarray(state.std)
        assert_agree(state, by_hand)
    assert by_hand.std_was_clipped


def test_samples_come_in_pairs_around_the_mean():
    for samples, state, _ in generations(SETTINGS, peak_at_one, 1):
        pairs = np.asarray(samples).reshape(2, 6, DIMENSIONS)
        np.testing.assert_allclose(pairs.mean(axis=0), np.tile(first_mean(), (6, 1)), atol=1e-6)
        assert len(np.unique(samples, axis=0)) == 12
        assert np.isfinite(state.mean).all()


@pytest.mark.precise
def test_equal_fitness_moves_nothing():
    for _, state, _ in generations(SETTINGS, lambda samples: np.full(len(samples), -3.0), 3):
        np.testing.assert_allclose(state.mean, first_mean(), atol=1e-6)
        np.testing.assert_allclose(state.std, 0.4, rtol=1e-6)


def test_only_the_order_of_the_fitness_matters():
    def stretched(samples):
        return -np.exp(-peak_at_one(samples) / 5.0)

    first = [state for _, state, _ in generations(SETTINGS, peak_at_one, 5)][-1]
    second = [state for _, state, _ in generations(SETTINGS, stretched, 5)][-1]
    np.testing.assert_array_equal(first.mean, second.mean)
    np.testing.assert_array_equal(first.std, second.std)


def test_it_moves_as_that_of_evosax():
    optimizer = clipup(SETTINGS.learning_rate, SETTINGS.max_speed, SETTINGS.momentum)
    theirs = EvosaxPGPE(SETTINGS.population, jnp.zeros(DIMENSIONS), optimizer=optimizer)
    numbers = theirs.default_params.replace(
        std_init=SETTINGS.std, std_lr=SETTINGS.std_lr, std_max_change=SETTINGS.std_max_change
    )
    their_state = theirs.init(jax.random.key(0), jnp.asarray(first_mean()), numbers)
    for number, (samples, state, _) in enumerate(generations(SETTINGS, with_ties, 25)):
        key = jax.random.fold_in(jax.random.key(0), number)
        their_samples, their_state = theirs.ask(key, their_state, numbers)
        np.testing.assert_allclose(their_samples, samples, atol=2e-5)
        loss = -jnp.asarray(with_ties(np.asarray(samples)), "float32")
        their_state, _ = theirs.tell(key, samples, loss, their_state, numbers)
        np.testing.assert_allclose(their_state.mean, state.mean, atol=2e-5)
        np.testing.assert_allclose(their_state.std, state.std, rtol=2e-5)


def test_the_fitness_rises():
    *_, (_, state, _) = generations(dataclasses.replace(SETTINGS, population=40), peak_at_one, 60)
    assert peak_at_one(np.asarray(state.mean)[None])[0] > -0.1


# Misuse.


@pytest.mark.parametrize("population", [1, 7, 63, 0, 2.5, math.nan])
def test_an_odd_population_is_refused(population):
    refused(f"^population is {population}; ", PGPE, population=population)


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
@pytest.mark.parametrize(
    "name", ["std", "std_lr", "std_max_change", "learning_rate", "max_speed", "momentum"]
)
def test_a_setting_out_of_range_is_refused(name, value):
    refused(rf"^{name} is .*; it must be", PGPE, **{name: value})


# Training.

EXPERIMENT = Experiment(
    name="ar",
    system=System(
        controller=recipe("AR-rF-reflex-w8").controller(32),
        omega=8.0,
        timing=Timing(duration_s=3.0),
    ),
    objective=Fitness(settle_s=1.0),
)
RUN = Run(
    experiment=EXPERIMENT,
    seeds=(3, 5),
    learner=Evolution(algorithm=PGPE(population=8), stopping=Stopping.after(4)),
)


@cache
def trained():
    """Two seeds, four generations."""
    return list(RUN.learner.evolve(RUN.experiment, RUN.seeds))


def test_a_seed_starts_alike_whichever_others_go_with_it():
    alone = RUN.learner.start(RUN.experiment, (5,))
    together = RUN.learner.start(RUN.experiment, RUN.seeds)
    np.testing.assert_array_equal(alone.best_weights[0], together.best_weights[1])
    assert not np.array_equal(together.best_weights[0], together.best_weights[1])


def test_every_seed_begins_with_weights_that_are_given():
    weights = tuple(np.linspace(-0.4, 0.4, EXPERIMENT.controller.n_weights).tolist())
    begun = dataclasses.replace(RUN.learner, weights=weights)
    start = begun.start(EXPERIMENT, RUN.seeds)
    np.testing.assert_array_equal(start.search.mean, np.float32([weights, weights]))
    assert begun.configuration(RUN)["weights"] == list(weights)
    assert "weights" not in RUN.learner.configuration(RUN)


def test_a_training_that_is_continued_is_the_same_as_one_without_pause():
    halfway, _ = trained()[1]
    scores = [curves.centre_fitness for _, curves in trained()[:2]]
    on = list(RUN.learner.evolve(RUN.experiment, RUN.seeds, halfway, scores))
    assert len(on) == 2
    end, _ = trained()[-1]
    np.testing.assert_array_equal(on[-1][0].search.mean, end.search.mean)
    np.testing.assert_array_equal(on[-1][0].best_weights, end.best_weights)


def test_the_best_distribution_seen_is_kept():
    fitness = np.array([curves.centre_fitness for _, curves in trained()])
    end, _ = trained()[-1]
    np.testing.assert_array_equal(end.best_fitness, fitness.max(axis=0))
    np.testing.assert_array_equal(end.best_generation, fitness.argmax(axis=0))
    # The mean before the first generation is generation 0's.
    baseline = [
        RUN.learner.start(RUN.experiment, RUN.seeds),
        *(progress for progress, _ in trained()),
    ]
    for seed, generation in enumerate(np.asarray(end.best_generation)):
        search = baseline[generation].search
        np.testing.assert_array_equal(end.best_weights[seed], search.mean[seed])
        np.testing.assert_array_equal(end.best_std[seed], search.std[seed])


def test_the_curves_tell_the_state_of_every_seed():
    for progress, curves in trained():
        assert all(entry.shape == (2,) for entry in curves)
        assert (curves.best_fitness >= curves.mean_fitness).all()
        assert ((curves.failed_share >= 0.0) & (curves.failed_share <= 1.0)).all()
        assert (progress.generation == progress.generation[0]).all()
    assert [int(progress.generation[0]) for progress, _ in trained()] == [1, 2, 3, 4]


def test_an_episode_too_short_to_be_judged_is_refused():
    with pytest.raises(TegotaeError, match=r"^an episode of 4 s leaves less than 1 s") as raised:
        replace(EXPERIMENT, {"objective": Fitness(), "timing": Timing(duration_s=4.0)})
    assert "\n" not in str(raised.value)
