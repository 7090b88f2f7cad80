"""The hopper does what it did before its controller became a network of one unit."""

from __future__ import annotations

import numpy as np
import pytest

import kept_hopper


@pytest.fixture(scope="module")
def kept() -> dict[str, np.ndarray]:
    return kept_hopper.kept()


def agree(kept: dict[str, np.ndarray], found: dict[str, np.ndarray], *, to: float) -> None:
    for name, before in kept.items():
        if name not in found:
            continue
        after = found[name]
        assert after.shape == before.shape, name
        np.testing.assert_allclose(
            np.asarray(after, float), np.asarray(before, float), rtol=to, atol=to, err_msg=name
        )


def test_trajectories_are_the_same_but_for_rounding(kept):
    found = kept_hopper.trajectories()
    double = {name: values for name, values in found.items() if ".float64." in name}
    assert len(double) > 50
    agree(kept, double, to=1e-9)
    agree(kept, {name: found[name] for name in found.keys() - double.keys()}, to=2e-3)


@pytest.mark.thorough
def test_a_training_and_its_evaluation_are_the_same_but_for_rounding(kept):
    found = kept_hopper.study()
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    agree(kept, {name: found[name] for name in ("study.weights", "study.best_fitness")}, to=1e-2)
    curves = {name: found[name] for name in found if name.startswith("study.curves.centre")}
    agree(kept, curves, to=1e-2)


def test_an_evaluation_is_the_same_but_for_rounding(kept):
    found = kept_hopper.evaluation()
    assert np.isfinite(found["evaluation.cot_inverse"]).any()
    agree(kept, found, to=1e-2)
