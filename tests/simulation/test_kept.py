"""Hopper, walker and a training on MuJoCo do what they did before, but for rounding.

`kept_results` says how it was kept.
"""

import numpy as np
import pytest

import kept_results


def agree(pinned: dict[str, np.ndarray], results: dict[str, np.ndarray], *, to: float) -> None:
    assert results.keys() & pinned.keys()
    for name in results.keys() & pinned.keys():
        expected, actual = np.asarray(pinned[name], float), np.asarray(results[name], float)
        assert actual.shape == expected.shape, name
        np.testing.assert_allclose(actual, expected, rtol=to, atol=to, err_msg=name)


@pytest.fixture(scope="module")
def pinned() -> dict[str, np.ndarray]:
    return kept_results.kept("hopper")


def test_trajectories_of_the_hopper(pinned):
    results = kept_results.trajectories()
    double = {name: values for name, values in results.items() if ".float64." in name}
    assert len(double) > 50
    agree(pinned, double, to=1e-9)
    agree(pinned, {name: results[name] for name in results.keys() - double.keys()}, to=2e-3)


@pytest.mark.thorough
def test_a_training_of_the_hopper_and_its_evaluation(pinned):
    results = kept_results.study()
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    agree(
        pinned, {name: results[name] for name in ("study.weights", "study.best_fitness")}, to=1e-2
    )
    curves = {name: results[name] for name in results if name.startswith("study.curves.centre")}
    agree(pinned, curves, to=1e-2)


def test_an_evaluation_of_the_hopper(pinned):
    results = kept_results.evaluation()
    assert np.isfinite(results["evaluation.cot_inverse"]).any()
    agree(pinned, results, to=1e-2)


@pytest.fixture
def loops(monkeypatch):
    """XLA made what is kept of legs; engines of other last bits are held to it elsewhere."""
    pytest.importorskip("mujoco")
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    return kept_results.kept("loops")


def test_a_walker_walks_as_it_did(loops):
    results = kept_results.walker()
    assert results.keys() <= loops.keys()
    agree(loops, results, to=1e-9)


@pytest.mark.thorough
@pytest.mark.precise
def test_a_training_on_mujoco_learns_what_it_did(loops):
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    results = kept_results.mujoco_training()
    assert results.keys() <= loops.keys()
    agree(loops, results, to=1e-2)
