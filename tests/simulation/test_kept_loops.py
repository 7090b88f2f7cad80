"""A walker and a training on MuJoCo do what they did before; `kept_loops` says how it was kept."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

import kept_loops


@pytest.fixture(autouse=True)
def on_xla(monkeypatch):
    """What is kept was made by XLA; engines of other last bits are held to it elsewhere."""
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")


def agree(found: dict[str, np.ndarray], *, to: float) -> None:
    kept = kept_loops.kept()
    assert found
    for name, after in found.items():
        before = kept[name]
        assert after.shape == before.shape, name
        np.testing.assert_allclose(
            np.asarray(after, float), np.asarray(before, float), rtol=to, atol=to, err_msg=name
        )


def test_a_walker_walks_as_it_did_but_for_rounding():
    agree(kept_loops.walker(), to=1e-9)


@pytest.mark.precise
def test_a_training_on_mujoco_learns_what_it_did_but_for_rounding():
    # Three generations, which amplify rounding: other processors part in the fourth digit.
    agree(kept_loops.mujoco_training(), to=1e-2)
