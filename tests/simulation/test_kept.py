"""Hopper, walker and a training on MuJoCo do what they did before, but for rounding.

`kept_hopper` and `kept_loops` say how it was kept.
"""

from __future__ import annotations

import numpy as np
import pytest

import kept_hopper


def agree(kept: dict[str, np.ndarray], found: dict[str, np.ndarray], *, to: float) -> None:
    assert found.keys() & kept.keys()
    for name in found.keys() & kept.keys():
        before, after = np.asarray(kept[name], float), np.asarray(found[name], float)
        assert after.shape == before.shape, name
        np.testing.assert_allclose(after, before, rtol=to, atol=to, err_msg=name)


@pytest.fixture(scope="module")
def kept() -> dict[str, np.ndarray]:
    return kept_hopper.kept()


def test_trajectories_of_the_hopper(kept):
    found = kept_hopper.trajectories()
    double = {name: values for name, values in found.items() if ".float64." in name}
    assert len(double) > 50
    agree(kept, double, to=1e-9)
    agree(kept, {name: found[name] for name in found.keys() - double.keys()}, to=2e-3)


@pytest.mark.thorough
def test_a_training_of_the_hopper_and_its_evaluation(kept):
    found = kept_hopper.study()
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    agree(kept, {name: found[name] for name in ("study.weights", "study.best_fitness")}, to=1e-2)
    curves = {name: found[name] for name in found if name.startswith("study.curves.centre")}
    agree(kept, curves, to=1e-2)


def test_an_evaluation_of_the_hopper(kept):
    found = kept_hopper.evaluation()
    assert np.isfinite(found["evaluation.cot_inverse"]).any()
    agree(kept, found, to=1e-2)


@pytest.fixture
def loops(monkeypatch):
    """XLA made what is kept of legs; engines of other last bits are held to it elsewhere."""
    pytest.importorskip("mujoco")
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    import kept_loops

    return kept_loops


def test_a_walker_walks_as_it_did(loops):
    found = loops.walker()
    assert found.keys() <= loops.kept().keys()
    agree(loops.kept(), found, to=1e-9)


@pytest.mark.thorough
@pytest.mark.precise
def test_a_training_on_mujoco_learns_what_it_did(loops):
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    found = loops.mujoco_training()
    assert found.keys() <= loops.kept().keys()
    agree(loops.kept(), found, to=1e-2)
