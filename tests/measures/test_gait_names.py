"""Lags and the names of gaits, on made-up data: no body moves here."""

import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae.measures.gaits.lags import (
    OfPhases,
    OfTouchdowns,
    circular_mean,
    circular_spread,
    lag_difference,
    largest_drift,
    over_strides,
    stances,
    step_frequency_hz,
    time_to_lock,
)
from tegotae.measures.gaits.names import (
    NO_GAIT,
    PATTERNS,
    distance,
    gait_of,
    leg_names,
    names_of,
    nearest_pattern,
    patterns_for,
)
from tegotae.measures.gaits.summary import Coordination
from tegotae.parts.bodies import Bar, Hopper
from tegotae.simulation.recorder import Trajectory

FOUR = ("LH", "LF", "RH", "RF")
SIX = ("LH", "LM", "LF", "RH", "RM", "RF")
FRAME_S = 0.02
TIME_S = FRAME_S * np.arange(1, 1001)


def striding(lags, *, hz=1.25, sway=0.0, lanes_at=(0.0,)) -> Trajectory:
    """Legs that step at fixed lags: phases, and a touchdown whenever one passes zero."""
    turns = hz * TIME_S[:, None, None] + np.asarray(lanes_at)[None, None] - np.array(lags)[:, None]
    turns = turns + sway * np.sin(2 * np.pi * turns)
    down = np.floor(turns) > np.floor(np.roll(turns, 1, axis=0))
    down[0] = False
    late = (turns % 1.0) / hz  # since it passed zero, with an even pace
    return Trajectory(
        time_s=np.broadcast_to(TIME_S[:, None], turns[:, 0].shape),
        phase_rad=2 * np.pi * (turns % 1.0),
        touchdown_time_s=np.where(down, TIME_S[:, None, None] - late, np.nan),
    )


# Lags


def test_a_leg_that_steps_later_has_the_larger_lag():
    path = striding([0.0, 0.25, 0.9])
    for rhythm in (OfPhases(), OfTouchdowns()):
        lag = np.asarray(rhythm.lag(path, 0))[-1, :, 0]
        np.testing.assert_allclose(lag, [0.0, 0.25, 0.9], atol=1e-5)


def test_lags_are_measured_from_the_reference_leg():
    path = striding([0.0, 0.25, 0.9])
    for rhythm in (OfPhases(), OfTouchdowns()):
        lag = np.asarray(rhythm.lag(path, 1))[-1, :, 0]
        off = lag_difference(lag, np.array([0.75, 0.0, 0.65], "float32"))
        np.testing.assert_allclose(off, 0.0, atol=1e-5)


def test_lags_do_not_depend_on_when_a_lane_began():
    path = striding([0.0, 0.4], lanes_at=(0.0, 0.3, 0.77))
    for rhythm in (OfPhases(), OfTouchdowns()):
        np.testing.assert_allclose(rhythm.lag(path, 0)[-1, 1], 0.4, atol=1e-5)


@pytest.mark.parametrize("rhythm", [OfPhases(), OfTouchdowns()], ids=["phases", "touchdowns"])
def test_the_frequency_is_that_of_the_strides(rhythm):
    hz = rhythm.frequency_hz(striding([0.0, 0.5], hz=1.7), 0, 500)
    np.testing.assert_allclose(hz, 1.7, rtol=1e-3)


def test_lags_all_round_the_circle_have_no_mean_and_a_wide_spread():
    assert circular_spread(jnp.arange(8) / 8) > 0.5
    assert circular_spread(jnp.full(8, 0.3)) == pytest.approx(0.0, abs=1e-3)


def test_undefined_lags_do_not_enter_a_mean():
    lags = jnp.array([[0.2, jnp.nan], [jnp.nan, jnp.nan]])
    mean = np.asarray(circular_mean(lags))
    assert mean[0] == pytest.approx(0.2)
    assert np.isnan(mean[1])


def test_the_sway_within_a_stride_averages_out_over_it():
    path = striding([0.0, 0.5], sway=0.08)
    raw = OfPhases().lag(path, 0)
    smooth = over_strides(raw, jnp.array([40]))  # 0.8 s at 1.25 Hz
    assert np.ptp(np.asarray(raw)[:, 1]) > 0.2
    np.testing.assert_allclose(smooth[40:, 1], 0.5, atol=1e-3)


def test_each_lane_is_averaged_over_its_own_stride():
    raw = jnp.asarray(np.random.default_rng(0).uniform(0, 0.4, (200, 2, 2)).astype("float32"))
    averaged = over_strides(raw, jnp.array([20, 50]))
    for lane, frames in enumerate((20, 50)):
        mean = circular_mean(raw[150 - frames + 1 : 151, :, lane])
        np.testing.assert_allclose(averaged[150, :, lane], mean, atol=1e-4)


def test_the_time_to_lock_is_the_last_time_that_the_lags_come_near():
    # Once through the final lag on the way, then away, then there to stay.
    lag = jnp.array([0.1, 0.5, 0.9, 0.45, 0.5, 0.52])[:, None, None]
    assert time_to_lock(lag, jnp.array([[0.5]]), jnp.arange(6.0), 0.06).tolist() == [3.0]


def test_what_is_away_at_the_end_is_not_locked():
    lag = jnp.array([0.5, 0.5, 0.8])[:, None, None]
    assert np.isnan(time_to_lock(lag, jnp.array([[0.5]]), jnp.arange(3.0), 0.05)).all()


def test_lags_that_stand_still_have_not_moved():
    lag = jnp.stack([jnp.full((9, 1), 0.3), 0.3 + 0.05 * jnp.arange(9.0)[:, None]], axis=-1)
    np.testing.assert_allclose(largest_drift(lag), [0.0, 0.4], atol=1e-6)


def test_steps_are_counted_from_the_first_touchdown_to_the_last():
    times = np.full((10, 2, 1), np.nan)
    times[[1, 4, 8], 0, 0] = [1.0, 1.4, 2.0]
    hz = np.asarray(step_frequency_hz(times))
    assert hz[0, 0] == pytest.approx(2.0)
    assert np.isnan(hz[1, 0])


# Footfalls


def test_stances_begin_and_end_within_frames():
    time = 0.1 * np.arange(1, 8)
    gained = np.array([0.0, 0.03, 0.1, 0.06, 0.0, 0.0, 0.1])
    (stance,) = stances(time, np.cumsum(gained)[:, None])
    assert [(s.touchdown_s, s.liftoff_s) for s in stance] == [(0.17, 0.36), (0.6, 0.7)]


def test_a_leg_that_never_touches_the_ground_has_no_stance():
    assert stances(0.1 * np.arange(1, 4), np.zeros((3, 2))) == ((), ())


# Legs


def test_legs_are_named_by_hind_and_fore_left_and_right():
    assert leg_names(Bar()) == ("H", "F")
    assert names_of((1, 1, -1, -1), (1, -1, 1, -1)) == ("LF", "RF", "LH", "RH")
    assert set(names_of((-1, 0, 1) * 2, (1,) * 3 + (-1,) * 3)) == set(SIX)


def test_legs_whose_places_say_nothing_are_numbered():
    assert leg_names(Hopper()) == ("1",)
    assert leg_names(Bar(hips_m=(-0.6, -0.2, 0.2, 0.6))) == ("1", "2", "3", "4")


# Names


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda p: f"{p.name} of {len(p.lags)}")
@pytest.mark.parametrize("order", [1, -1], ids=["in order", "reversed"])
def test_every_pattern_has_its_own_name_from_any_reference_leg_and_mirrored(pattern, order):
    legs = tuple(pattern.lags)[::order]
    for variant in (pattern, pattern.mirrored()):
        lags = np.array([[variant.lags[leg]] for leg in legs])
        for reference in range(len(legs)):
            assert nearest_pattern((lags - lags[reference]) % 1.0, legs) == pattern.name


@pytest.mark.parametrize("legs", [("H", "F"), ("L", "R"), FOUR, SIX], ids=len)
def test_no_pattern_has_the_lags_of_another_within_the_tolerance(legs):
    rows = [(p.name, np.array([[p.lags[leg]] for leg in legs])) for p in patterns_for(legs)]
    for i, (name, row) in enumerate(rows):
        for neighbour, far in rows[i + 1 :]:
            if name != neighbour:
                assert distance(row, far)[0] > 0.1 - 1e-9  # a transverse gallop and a bound


@pytest.mark.parametrize(
    ("fore", "name"),
    [(0.1, "in phase"), (0.11, "in between"), (0.39, "in between"), (0.4, "antiphase")],
)
def test_a_lag_up_to_the_tolerance_away_has_the_name_and_one_beyond_it_has_none(fore, name):
    assert nearest_pattern([[0.0], [fore]], ("H", "F")) == name
    assert nearest_pattern([[0.0], [1.0 - fore]], ("H", "F")) == name


def test_a_diagonal_walk_becomes_a_trot_with_something_in_between():
    behind = np.array([0.73, 0.67, 0.625, 0.58, 0.5])  # the fore leg, the hind leg of its side
    lags = np.stack([0 * behind, behind, 0.5 + 0 * behind, 0.5 + behind]) % 1.0
    walk, trot = "diagonal-sequence walk", "trot"
    assert nearest_pattern(lags, FOUR).tolist() == [walk, walk, "in between", trot, trot]


def test_legs_that_no_pattern_knows_are_in_phase_or_in_between():
    lags = [[0.0, 0.0], [0.02, 0.4], [0.97, 0.7]]
    assert nearest_pattern(lags, ("1", "2", "3")).tolist() == ["in phase", "in between"]


def test_undefined_lags_are_in_between():
    assert nearest_pattern([[0.0], [np.nan]], ("H", "F")) == "in between"


def test_lags_of_another_number_of_legs_are_refused():
    refused(r"lags have shape \(2, 1\); of 4 legs", nearest_pattern, [[0.0], [0.5]], FOUR)
    refused(r"tolerance is 0\.7", nearest_pattern, [[0.0], [0.5]], ("H", "F"), 0.7)


def coordination(**entries) -> Coordination:
    """The coordination of one lane of two legs in antiphase, but for some entries."""
    fields = {name: np.zeros(1) for name in Coordination._fields}
    fields |= {"lag": np.array([[0.0], [0.5]]), "moved": np.array([0.3])}
    fields |= {"cycle_frequency_hz": np.full(1, 1.2), "fall_time_s": np.array([np.nan])}
    return Coordination(**{**fields, **entries})


@pytest.mark.parametrize(
    ("entries", "name"),
    [
        ({}, "antiphase"),
        ({"lag": np.array([[0.0], [0.25]])}, "in between"),
        ({"lock_time_s": np.array([np.nan])}, "not locked"),
        ({"moved": np.zeros(1)}, "as released"),
        ({"cycle_frequency_hz": np.zeros(1)}, "standing"),
        ({"fall_time_s": np.array([3.0])}, "fallen"),
    ],
)
def test_a_lane_without_a_gait_says_why(entries, name):
    assert gait_of(coordination(**entries), ("H", "F")) == name
    assert name in (*NO_GAIT, "antiphase")


@pytest.mark.parametrize(
    ("lags", "duty", "flight", "name"),
    [
        ((0.0, 0.77, 0.14, 0.65), 0.42, 0.22, "rotary gallop"),  # 0.17 from the pattern
        ((0.0, 0.77, 0.14, 0.65), 0.42, 0.01, "in between"),  # without flight
        ((0.0, 0.77, 0.14, 0.65), 0.6, 0.22, "in between"),  # it does not run
        ((0.0, 0.3, 0.3, 0.7), 0.45, 0.0, "canter"),
        ((0.0, 0.3, 0.3, 0.7), 0.6, 0.0, "in between"),
        ((0.0, 0.45, 0.5, 0.95), 0.4, 0.2, "trot"),  # a named gait within the tolerance is nearer
    ],
)
def test_a_gallop_runs_and_flies_and_a_canter_runs(lags, duty, flight, name):
    gait = coordination(
        lag=np.array(lags)[:, None],
        duty_factor=np.full((4, 1), duty),
        flight_share=np.full(1, flight),
    )
    assert gait_of(gait, FOUR) == name
