"""Lesions: what happens to a body halfway, and who stays up."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib.image import imread

from tegotae import TegotaeError, Timing
from tegotae._support.tables import read_csv
from tegotae.analysis.gaits import random_phases, system
from tegotae.analysis.gaits.lesion import GaitLesion, aftermath
from tegotae.cli import main
from tegotae.parts.bodies import Walker
from tegotae.simulation.rollout import whole_trajectory

BAR = system("bar-light").with_system(timing=Timing(duration_s=60.0))
FOUR = (
    system("quadruped-c")
    .with_numbers(omega=2.2)
    .with_system(timing=Timing(duration_s=60.0, tick_s=0.008, frame_s=0.08))
)


@pytest.fixture(scope="module")
def lost():
    return aftermath(FOUR, GaitLesion(at_s=40.0, lost=("LH",)), 6)


# What happens


def test_nothing_before_the_lesion_knows_of_it_to_the_bit():
    timing = Timing(duration_s=4.0)
    phase = random_phases(2, 2)
    late = GaitLesion(at_s=2.0, fields=(("inertia_ratio", 1.6),)).scenario(BAR, phase)
    (name,) = late.changes
    never = late._replace(changes={name: late.changes[name]._replace(from_s=99.0)})
    with_it = BAR.run(whole_trajectory, late, timing)
    without = BAR.run(whole_trajectory, never, timing)
    cut = round(2.0 / timing.frame_s)
    np.testing.assert_array_equal(with_it.phase_rad[:cut], without.phase_rad[:cut])
    np.testing.assert_array_equal(with_it.height_m[:cut], without.height_m[:cut])
    assert (with_it.phase_rad[cut:] != without.phase_rad[cut:]).any()


@pytest.mark.thorough
def test_a_bar_that_grows_heavy_goes_from_antiphase_to_in_phase():
    found = aftermath(BAR, GaitLesion(at_s=30.0, fields=(("inertia_ratio", 1.6),)), 4)
    assert set(found.gait_before) == {"antiphase"}
    assert set(found.gait_after) == {"in phase"}
    assert found.share == (1.0, pytest.approx(0.51, abs=0.01), 1.0)
    np.testing.assert_allclose(np.abs(found.lag_change[1]), 0.49, atol=0.03)
    assert (found.after.lock_time_s > 1.0).all()  # counted from the lesion on
    assert (found.after.lock_time_s < 30.0).all()


def test_a_quadruped_that_loses_a_leg_falls(lost):
    assert lost.stood.all()
    assert not lost.stays.any()
    share, low, high = lost.share
    assert share == low == 0.0
    assert 0.3 < high < 0.5
    assert set(lost.gait_before) == {"diagonal-sequence walk"}
    assert set(lost.gait_after) == {"fallen"}
    assert lost.margin_m == pytest.approx(0.0)  # its mass is on the edge of any three feet
    assert (lost.after.fall_time_s > 0.0).all()
    assert (lost.after.fall_time_s < 20.0).all()


@pytest.mark.thorough
def test_legs_that_never_felt_each_other_are_not_locked_after_a_lesion_either():
    deaf = BAR.with_numbers(sigma=0.0).with_system(timing=Timing(duration_s=20.0))
    found = aftermath(deaf, GaitLesion(at_s=10.0, fields=(("mass_kg", 0.12),)), 2)
    assert set(found.gait_before) == set(found.gait_after) == {"as released"}


@pytest.mark.thorough
def test_the_cost_of_transport_after_a_load_is_that_of_the_loaded_body():
    timing = Timing(duration_s=48.0, tick_s=0.008, frame_s=0.08)
    heavy = (("mass_kg", 1.1),)
    found = aftermath(FOUR, GaitLesion(at_s=16.0, fields=heavy), 2, timing=timing)
    for each, mass_kg in ((found.before, 1.0), (found.after, 1.1)):
        weight = each.power_w / (each.cost_of_transport * each.speed_m_per_s)
        np.testing.assert_allclose(weight, mass_kg, rtol=1e-5)


def test_lags_are_then_measured_from_a_leg_that_is_left(lost):
    assert lost.left == (0, 1, 3)
    assert lost.reference == 0
    assert lost.before.lag.shape == (4, 6)
    assert lost.after.lag.shape == (3, 6)
    np.testing.assert_array_equal(lost.before.lag[0] % 1.0, 0.0)


# Misuse


@pytest.mark.parametrize(
    ("lesion", "line"),
    [
        ({"lost": ("LM",)}, "no leg of this body is called 'LM'; did you mean"),
        ({"lost": ("LH", "RH", "LF")}, "1 of 4 legs is left"),
        ({"fields": (("mass", 2.0),)}, "no number of a Walker is called 'mass'; did you mean"),
        ({"fields": (("mass_kg", -1.0),)}, "mass_kg is -1"),
        ({"drop_m": 0.1, "at_s": 60.0}, "at_s is 60; it must be from"),
    ],
)
def test_a_lesion_that_cannot_be_is_told_before_anything_moves(lesion, line):
    with pytest.raises(TegotaeError, match=line):
        aftermath(FOUR, GaitLesion(**{"at_s": 40.0, **lesion}), 2)


def test_a_lesion_in_which_nothing_happens_is_none():
    with pytest.raises(TegotaeError, match="nothing happens: name a leg to lose"):
        GaitLesion(at_s=1.0)


def test_a_leg_is_lost_once():
    three = FOUR.with_system(body=Walker(present=(1.0, 1.0, 0.0, 1.0)))
    with pytest.raises(TegotaeError, match="leg LH is lost already"):
        GaitLesion(at_s=1.0, lost=("LH",)).left(three)


def test_a_body_whose_legs_cannot_be_lost_says_so():
    with pytest.raises(TegotaeError, match="a Bar cannot lose a leg: it does not say which"):
        GaitLesion(at_s=1.0, lost=("H",)).left(BAR)


# The command


def test_the_command_writes_a_picture_and_the_same_rows_twice(tmp_path, capsys, lost):
    words = ["gait", "lesion", "quadruped-c", "--lose", "LH", "--omega", "2.2", "--at", "40"]
    words += ["--duration", "60", "--starts", "6", "--out", str(tmp_path)]
    assert main(words) == 0
    assert "0 of 6 that stood stay up" in capsys.readouterr().out
    table = read_csv(tmp_path / "lesion.csv")
    document = json.loads((tmp_path / "lesion.json").read_text())
    assert [row["gait_after"] for row in document["rows"]] == table["gait_after"].tolist()
    assert document["stays_up"]["of"] == 6
    assert imread(tmp_path / "lesion.png").std() > 0.01


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ([], "nothing happens"),
        (["--lose", "XX"], "no leg of this body is called 'XX'"),
        (["--then", "mass_kg"], "--then mass_kg sets nothing"),
        (["--then", "mass_kg=1,2"], "--then mass_kg has 2 numbers; name one"),
    ],
)
def test_what_cannot_happen_is_told_in_one_line(tmp_path, capsys, options, line):
    assert main(["gait", "lesion", "quadruped-c", *options, "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err.strip()
    assert line in told
    assert "\n" not in told
