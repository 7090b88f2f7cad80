"""Several legs are measured by metrics of one contract, the package's own and users'."""

import dataclasses

import numpy as np
import own_metrics
import pytest

import tegotae as tg
from refusals import refused
from tegotae import TegotaeError
from tegotae.measures.check import check
from tegotae.measures.gaits.metrics import WALKING, Walks
from tegotae.parts.bodies import Walker


@pytest.mark.parametrize("name", WALKING.names())
def test_the_metrics_of_legs_keep_the_contract(name):
    check(WALKING.find(name))


def test_a_users_metric_of_legs_is_evaluated_from_its_file():
    names = ["upright", "own_metrics:largest_pitch_rad"]
    table = tg.load("quadruped-c").evaluate(starts=2, metric=names)
    assert "largest pitch [rad]" in repr(table)
    assert 0.0 < table.table["largest_pitch_rad"].item() < 0.5
    assert "froude" not in table.table


def test_a_metric_of_a_hopper_is_refused_for_legs():
    with pytest.raises(TegotaeError, match="is a metric of hopping; here is walking"):
        tg.load("quadruped-c").evaluate(metric=["own_metrics:first_apex_m"])


def test_the_mean_over_the_starts_leaves_out_those_that_fall():
    columns = {
        "fall_time_s": [np.nan, 3.0, np.nan, np.nan],
        "speed_m_per_s": [0.2, np.nan, 0.1, 0.3],
        "gait": ["trot", "fell", "trot", "in between"],
    }
    walks = Walks(columns, 2, Walker())
    assert WALKING.find("upright").values(walks).tolist() == [0.5, 1.0]
    assert WALKING.find("speed_m_per_s").values(walks).tolist() == pytest.approx([0.2, 0.2])
    with pytest.raises(TegotaeError, match="no quantity of a walk is called 'speed'"):
        walks["speed"]


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"compute": lambda walks: walks["speed_m_per_s"].mean()}, r"it must be \[rows, starts\]"),
        (
            {"compute": lambda walks: walks["froude"] / walks["froude"].mean()},
            "lets one row change another",
        ),
        ({"range": (0.0, 1e-9)}, "outside of the range"),
        ({"channels": "pitch_rad"}, "it must be a tuple of names"),
    ],
)
def test_the_check_says_what_is_wrong_with_a_metric_of_legs(changed, says):
    check(own_metrics.largest_pitch_rad)
    refused(says, lambda: check(dataclasses.replace(own_metrics.largest_pitch_rad, **changed)))
