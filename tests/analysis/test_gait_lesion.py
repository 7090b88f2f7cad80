"""Lesions: what happens to a body halfway, and who stays up."""

import numpy as np
import pytest

from refusals import refused
from tegotae import Timing
from tegotae.analysis.gaits.lesion import GaitLesion, aftermath
from tegotae.api import gaits
from tegotae.parts.bodies import Bar, Walker
from tegotae.parts.fields import replace
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems.legged import random_phases
from tegotae.systems.resolve import legged_system as system

BAR = replace(system("bar-light"), {"timing": Timing(duration_s=60.0)})
FOUR = replace(
    system("quadruped-c").with_numbers(omega=2.2),
    {"timing": Timing(duration_s=60.0, tick_s=0.008, frame_s=0.08)},
)


@pytest.fixture(scope="module")
def lesion():
    return aftermath(FOUR, GaitLesion(at_s=40.0, lost=("LH",)), 6)


# What happens


def test_nothing_before_the_lesion_knows_of_it_to_the_bit():
    timing = Timing(duration_s=4.0)
    phase = random_phases(2, 2)
    late = GaitLesion(at_s=2.0, fields=(("inertia_ratio", 1.6),)).scenario(BAR, phase)
    (name,) = late.changes
    never = late._replace(changes={name: replace(late.changes[name], {"from_s": 99.0})})
    with_it = BAR.run(whole_trajectory, late, timing)
    without = BAR.run(whole_trajectory, never, timing)
    cut = round(2.0 / timing.frame_s)
    np.testing.assert_array_equal(with_it.phase_rad[:cut], without.phase_rad[:cut])
    np.testing.assert_array_equal(with_it.height_m[:cut], without.height_m[:cut])
    assert (with_it.phase_rad[cut:] != without.phase_rad[cut:]).any()


@pytest.mark.thorough
def test_a_bar_that_grows_heavy_goes_from_antiphase_to_in_phase():
    result = aftermath(BAR, GaitLesion(at_s=30.0, fields=(("inertia_ratio", 1.6),)), 4)
    assert set(result.frame.gait_before) == {"antiphase"}
    assert set(result.frame.gait_after) == {"in phase"}
    assert str(result.share) == "1 [0.51, 1]"
    np.testing.assert_allclose(np.abs(result.frame.lag_change_cycles_F), 0.49, atol=0.03)
    assert (result.frame.after_lock_time_s > 1.0).all()  # counted from the lesion on
    assert (result.frame.after_lock_time_s < 30.0).all()


def test_a_quadruped_that_loses_a_leg_falls(lesion):
    assert lesion.frame.stood_before.all()
    assert not lesion.frame.stays_up.any()
    assert lesion.share.mean == lesion.share.low == 0.0
    assert 0.3 < lesion.share.high < 0.5
    assert set(lesion.frame.gait_before) == {"diagonal-sequence walk"}
    assert set(lesion.frame.gait_after) == {"fallen"}
    assert lesion.margin_m == pytest.approx(0.0)  # its mass is on the edge of any three feet
    assert (lesion.frame.after_fall_time_s > 0.0).all()
    assert (lesion.frame.after_fall_time_s < 20.0).all()


@pytest.mark.thorough
def test_legs_that_never_felt_each_other_are_not_locked_after_a_lesion_either():
    deaf = replace(BAR.with_numbers(sigma=0.0), {"timing": Timing(duration_s=20.0)})
    result = aftermath(deaf, GaitLesion(at_s=10.0, fields=(("mass_kg", 0.12),)), 2)
    assert set(result.frame.gait_before) == set(result.frame.gait_after) == {"as released"}


@pytest.mark.thorough
def test_the_cost_of_transport_after_a_load_is_that_of_the_loaded_body():
    four = replace(FOUR, {"timing": Timing(duration_s=48.0, tick_s=0.008, frame_s=0.08)})
    heavy = (("mass_kg", 1.1),)
    frame = aftermath(four, GaitLesion(at_s=16.0, fields=heavy), 2).frame
    for part, mass_kg in (("before", 1.0), ("after", 1.1)):
        cost = frame[f"{part}_cost_of_transport"] * frame[f"{part}_speed_m_per_s"]
        weight = frame[f"{part}_power_w"] / cost
        np.testing.assert_allclose(weight, mass_kg, rtol=1e-5)


def test_lags_are_then_measured_from_a_leg_that_is_left(lesion):
    assert lesion.left == (0, 1, 3)
    assert lesion.reference == 0
    assert len(lesion.frame) == 6
    assert [x for x in lesion.frame if x.startswith("after_lag_cycles")][
        -1
    ] == "after_lag_cycles_RH"
    np.testing.assert_array_equal(lesion.frame.before_lag_cycles_LF % 1.0, 0.0)


# Misuse


@pytest.mark.parametrize(
    ("lesion", "line", "body"),
    [
        ({"lost": ("LM",)}, "no leg of this body is called 'LM'; did you mean", None),
        ({"lost": ("LH", "RH", "LF")}, "1 of 4 legs is left", None),
        ({"lost": ("LH",)}, "leg LH is lost already", Walker(present=(1.0, 1.0, 0.0, 1.0))),
        ({"lost": ("H",)}, "a Bar cannot lose a leg: it does not say which", Bar()),
        ({"lost": ("LH",), "lasts_s": 1.0}, "a lost leg or a drop is for good", None),
        ({"fields": (("mass", 2.0),)}, "no number of a Walker is called 'mass'; did you", None),
        ({"fields": (("mass_kg", -1.0),)}, "mass_kg is -1", None),
        ({"fields": (("push_y_n", 0.3),), "lasts_s": 0.0}, "lasts_s is 0", None),
        ({"drop_m": 0.1, "at_s": 60.0}, "at_s is 60; it must be from", None),
        ({}, "nothing happens: name a leg to lose", None),
    ],
)
def test_a_lesion_that_cannot_be_is_told_before_anything_moves(lesion, line, body):
    legged = (
        BAR if isinstance(body, Bar) else FOUR if body is None else replace(FOUR, {"body": body})
    )
    refused(line, lambda: aftermath(legged, GaitLesion(**{"at_s": 40.0, **lesion}), 2))


# The question


def test_the_answer_tells_who_stays_up_and_has_a_picture(lesion):
    answer = gaits.perturb(
        "quadruped-c", lose=("LH",), omega=2.2, at_s=40.0, duration_s=60.0, starts=6
    )
    assert "LH lost at 40 √(l0/g): 0 of 6 that stood stay up" in answer.title
    assert answer.to_dict()["stays_up"]["of"] == 6
    assert set(answer.table.gait_after) == set(lesion.frame.gait_after)
    answer.plot().draw_without_rendering()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"then": ("mass_kg",)}, "then mass_kg sets nothing"),
        ({"then": ("mass_kg=1,2",)}, "then mass_kg=1,2 sets nothing"),
    ],
)
def test_what_cannot_happen_is_told(options, line):
    refused(line, gaits.perturb, "quadruped-c", **options)
