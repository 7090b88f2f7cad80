"""A search of a study goes on from its last whole generation, to the same end."""

import jax
import numpy as np
import pytest

from tegotae.training.algorithms import CMAES

GOAL = np.array([1.0, -2.0, 0.5])


def near_goal(candidates, generation):
    return -((candidates - GOAL) ** 2).sum(axis=1)


@pytest.fixture(autouse=True)
def promotion():
    with jax.numpy_dtype_promotion("standard"):  # which evosax counts on
        yield


def test_an_interrupted_search_ends_as_an_uninterrupted_one_and_near_the_goal(tmp_path, study):
    search = study("search").search
    algorithm, start = CMAES(population=8, std=0.5), np.zeros(3)

    def interrupted(candidates, generation):
        if generation == 5:
            raise KeyboardInterrupt
        return near_goal(candidates, generation)

    mean, scores = search(tmp_path / "whole.npz", algorithm, start, 40, near_goal, seed=3)
    assert scores.shape == (40, 8)
    assert np.abs(mean - GOAL).max() < 0.05
    with pytest.raises(KeyboardInterrupt):
        search(tmp_path / "half.npz", algorithm, start, 40, interrupted, seed=3)
    again, all_scores = search(tmp_path / "half.npz", algorithm, start, 40, near_goal, seed=3)
    np.testing.assert_array_equal(again, mean)
    np.testing.assert_array_equal(all_scores, scores)
