"""Summaries of many rollouts: sweeps over gain and frequency, ridges, lockings and basins."""

from fractions import Fraction
from functools import cache

import jax
import numpy as np
import pytest
from hypothesis import given, strategies as st

from refusals import refused
from research.reproduction.ridge import find_losses, find_resonance, find_ridge, one_to_one_ridge
from synthetic import Hopping, seconds
from tegotae import Hopper, Scenario, TegotaeError, Timing
from tegotae.analysis.maps import (
    GainSweep,
    Outcome,
    OutcomeSummary,
    axis,
    distinct_cycles,
    locking_ratios,
    map_basin,
    sweep_gain,
)
from tegotae.measures.hopping.metrics import AT_REST, FAILED, LIMIT_CYCLE, UNSETTLED
from tegotae.measures.hopping.recording import from_samples
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe

TIMING = Timing(duration_s=16.0, tick_s=0.002)
OMEGA = np.array([4.5, 6.0, 9.0])
SIGMA = np.array([0.0, 3.5, 8.0])


@cache
def sweep(model: str) -> GainSweep:
    return sweep_gain(recipe(model).controller(), SIGMA, OMEGA, timing=TIMING)


def outcome_of(hopping: Hopping, turns_per_hop: float, duration_s: float = 20.0) -> Outcome:
    """The outcome of a synthetic recording whose oscillator turns steadily per hop."""
    time_s = seconds(duration_s)
    steps = 2.0 * np.pi * (turns_per_hop - 1.0) * np.arange(len(hopping.apex_m))
    frames = from_samples(
        time_s,
        hopping.height_m(time_s),
        rest_length_m=1.0,
        ground_m=0.0,
        phase_rad=hopping.phase_rad(time_s, steps) % (2.0 * np.pi),
        force_n=np.ones_like(time_s),
        frame_s=0.02,
    )
    with jax.enable_x64(True):
        return Outcome(*(np.asarray(x)[0] for x in _summarise(frames)))


@jax.jit
def _summarise(frames):
    return OutcomeSummary()(frames, Scenario(omega=6.0), Hopper(), Timing(duration_s=20.0))


# The outcome of one gait.


@pytest.mark.parametrize("turns", [1.0, 2.0, 3.0])
def test_rates_of_a_recorded_gait_whose_oscillator_turns_so_often_per_hop(turns):
    hopping = Hopping(np.full(40, 1.2))
    outcome = outcome_of(hopping, turns)
    hop_s = np.diff(hopping.apex_s)[0]
    assert outcome.regime == LIMIT_CYCLE
    assert outcome.hop_rate == pytest.approx(2.0 * np.pi / hop_s, rel=1e-3)
    assert outcome.phase_rate == pytest.approx(turns * 2.0 * np.pi / hop_s, rel=1e-3)
    assert outcome.winding_ratio == pytest.approx(turns, rel=1e-4)
    assert outcome.apex_height_m == pytest.approx(1.2, abs=1e-3)


def test_an_oscillator_that_slips_past_the_hops_is_on_no_limit_cycle_but_has_its_rates():
    outcome = outcome_of(Hopping(np.full(40, 1.2)), 1.0 + 0.5 * (5.0**0.5 - 2.0))
    assert outcome.regime == UNSETTLED
    assert outcome.winding_ratio == pytest.approx(1.0 + 0.5 * (5.0**0.5 - 2.0), rel=1e-3)


def test_the_mean_apex_of_a_cycle_of_two_hops_is_taken_over_both():
    outcome = outcome_of(Hopping(np.tile([1.1, 1.3], 20)), 1.5)
    assert outcome.limit_cycle_period == 2
    assert outcome.apex_height_m == pytest.approx(1.2, abs=1e-3)
    assert outcome.winding_ratio == pytest.approx(1.5, rel=1e-3)


def test_a_body_at_rest_has_a_phase_rate_but_no_hopping_frequency():
    outcome = outcome_of(Hopping(np.array([1.2])), 1.0)
    assert outcome.regime == AT_REST
    assert np.isnan(outcome.hop_rate)
    assert np.isnan(outcome.apex_height_m)
    assert np.isnan(outcome.winding_ratio)
    assert outcome.phase_rate == 0.0  # the recorded phase stands still


# Sweeps.


def test_an_uncoupled_oscillator_runs_at_its_own_frequency():
    outcome = sweep("V-sector-w4").outcome
    alive = outcome.regime[0] != FAILED
    assert alive.any()
    np.testing.assert_allclose(outcome.phase_rate[0][alive], OMEGA[alive], rtol=1e-4)


def test_without_gain_a_reflex_does_nothing_and_the_body_comes_to_rest():
    outcome = sweep("V-reflex-w4").outcome
    assert (outcome.regime[0] == AT_REST).all()
    assert np.isnan(outcome.hop_rate[0]).all()
    assert (outcome.cot_inverse[0] == 0.0).all()


@pytest.mark.parametrize("model", ["V-sector-w4", "V-reflex-w4"])
def test_on_a_limit_cycle_the_oscillator_makes_a_whole_number_of_turns(model):
    outcome = sweep(model).outcome
    settled = outcome.regime == LIMIT_CYCLE
    assert settled.any()
    turns = (outcome.winding_ratio * outcome.limit_cycle_period)[settled]
    np.testing.assert_allclose(turns, np.round(turns), atol=0.01)
    assert np.isnan(outcome.limit_cycle_period[~settled]).all()


def test_the_batch_equals_its_rollouts_one_by_one():
    batch = sweep("V-sector-w4")
    for row, column in ((1, 1), (2, 0)):
        single = sweep_gain(
            recipe("V-sector-w4").controller(), SIGMA[[row]], OMEGA[[column]], timing=TIMING
        ).outcome
        for name, value in single._asdict().items():
            expected = getattr(batch.outcome, name)[row, column]
            np.testing.assert_allclose(value[0, 0], expected, rtol=1e-4, atol=1e-4, err_msg=name)


def test_a_controller_with_other_weights_than_the_gain_is_refused():
    with pytest.raises(TegotaeError, match="weights; a gain sweep needs one whose only weight"):
        sweep_gain(recipe("ART").controller(), SIGMA, OMEGA)


@pytest.mark.parametrize(
    ("low", "high", "points", "message"),
    [
        (2.0, 2.0, 5, "goes from 2 to 2; the second must be greater"),
        (3.0, 2.0, 5, "goes from 3 to 2"),
        (0.0, float("nan"), 5, "must be finite"),
        (0.0, 1.0, 1, "at least 2"),
    ],
)
def test_an_axis_that_is_none_is_refused_in_one_line(low, high, points, message):
    refused(message, axis, "omega", low, high, points)


# Ridges.


@given(
    slope=st.floats(-1.0, 1.0),
    intercept=st.floats(4.0, 6.0),
)
def test_a_straight_ridge_is_found_to_half_a_cell(slope, intercept):
    omega, sigma = np.linspace(0.0, 4.0, 21), np.linspace(0.0, 10.0, 401)
    hill = np.exp(-((sigma[:, None] - intercept - slope * omega) ** 2))
    ridge = find_ridge(sigma, omega, hill)
    np.testing.assert_allclose(ridge.sigma, intercept + slope * omega, atol=0.0126)
    assert ridge.slope == pytest.approx(slope, abs=0.01)
    assert ridge.intercept == pytest.approx(intercept, abs=0.02)
    np.testing.assert_allclose(ridge.line(omega), intercept + slope * omega, atol=0.03)


def test_r_squared_and_slope_error_of_known_numbers():
    """The textbook line through (1, 2), (2, 1), (3, 4), (4, 3): slope 0.6, intercept 1, R² 0.36."""
    sigma, omega = np.arange(6.0), np.array([1.0, 2.0, 3.0, 4.0])
    hill = (sigma[:, None] == np.array([2.0, 1.0, 4.0, 3.0])) * 1.0
    ridge = find_ridge(sigma, omega, hill)
    assert ridge.slope == pytest.approx(0.6)
    assert ridge.intercept == pytest.approx(1.0)
    assert ridge.r_squared == pytest.approx(0.36)
    assert ridge.slope_error == pytest.approx((3.2 / 2 / 5) ** 0.5)
    low, high = ridge.r_squared_interval
    assert 0.0 <= low < 0.36 < high <= 1.0


def test_frequencies_without_a_gait_have_no_best_gain():
    hill = np.array([[0.0, np.nan, 1.0], [0.0, 2.0, 0.5]])
    ridge = find_ridge(np.array([1.0, 2.0]), np.array([4.0, 5.0, 6.0]), hill)
    assert ridge.omega.tolist() == [5.0, 6.0]
    assert ridge.sigma.tolist() == [2.0, 1.0]
    assert np.isnan(ridge.slope)
    assert np.isnan(ridge.r_squared)


def test_a_level_ridge_has_no_variance_to_explain():
    hill = np.array([[1.0] * 4, [2.0] * 4, [1.0] * 4])
    ridge = find_ridge(np.array([1.0, 2.0, 3.0]), np.arange(4.0), hill)
    assert ridge.slope == 0.0
    assert np.isnan(ridge.r_squared)


def test_a_best_gain_at_the_edge_of_the_map_is_marked_and_not_fitted():
    """A straight ridge that leaves the map at both ends, where it would be bent."""
    sigma, omega = np.linspace(0.0, 4.0, 41), np.linspace(-2.0, 8.0, 21)
    hill = np.exp(-((sigma[:, None] - 0.5 * omega - 0.2) ** 2))
    ridge = find_ridge(sigma, omega, hill)
    beyond = (0.5 * omega + 0.2 <= 0.0) | (0.5 * omega + 0.2 >= 4.0)
    assert ridge.censored.tolist() == beyond.tolist()
    assert len(ridge.sigma) == len(omega)
    assert ridge.slope == pytest.approx(0.5, abs=0.01)
    assert ridge.r_squared == pytest.approx(1.0, abs=1e-3)
    assert np.polyfit(ridge.omega, ridge.sigma, 1)[0] < 0.46


def test_a_ridge_along_the_edge_has_no_line():
    hill = np.array([[1.0] * 4, [1.5] * 4, [2.0] * 4])
    ridge = find_ridge(np.array([1.0, 2.0, 3.0]), np.arange(4.0), hill)
    assert ridge.censored.all()
    assert ridge.sigma.tolist() == [3.0] * 4
    assert np.isnan(ridge.slope)
    assert np.isnan(ridge.r_squared_interval).all()


def test_a_frequency_is_best_for_a_gain_and_what_lies_beside_it_is_lost():
    sigma, omega = np.array([1.0, 2.0, 3.0]), np.arange(2.0, 9.0)
    peak = np.maximum(0.0, 3.0 - np.abs(omega - 5.0))
    value = np.stack([peak, 2.0 * peak, np.full(7, np.nan)])
    best = find_resonance(sigma, omega, value)
    assert best.sigma.tolist() == [1.0, 2.0], "the third gain never hops"
    assert best.omega.tolist() == [5.0, 5.0]
    losses = find_losses(sigma, omega, value)
    assert losses.omega.tolist() == [3.0, 4.0, 5.0, 6.0, 7.0]
    assert losses.sigma.tolist() == [2.0] * 5
    assert losses.loss == pytest.approx([0.0, 0.0, 1 / 3, 0.0, 0.0])


def test_the_one_to_one_ridge_leaves_other_lockings_out():
    shape = (2, 4)
    outcome = Outcome(
        regime=np.full(shape, LIMIT_CYCLE),
        limit_cycle_period=np.ones(shape),
        cot_inverse=np.array([[1.0] * 4, [5.0] * 4]),
        cot_inverse_total=np.ones(shape),
        apex_height_m=np.ones(shape),
        hop_rate=np.ones(shape),
        phase_rate=np.array([[1.0] * 4, [2.0] * 4]),
    )
    ridge = one_to_one_ridge(GainSweep(np.array([3.0, 6.0]), np.arange(4.0), outcome))
    assert ridge.sigma.tolist() == [3.0] * 4


# Lockings.


def test_locking_ratios_are_fractions_in_lowest_terms():
    outcome = _outcomes(
        regime=[LIMIT_CYCLE, LIMIT_CYCLE, LIMIT_CYCLE, UNSETTLED],
        period=[1, 2, 2, np.nan],
        winding=[1.0001, 0.998, 1.501, 1.3],
    )
    assert locking_ratios(outcome).tolist() == [Fraction(1), Fraction(1), Fraction(3, 2), None]


# Basins.


def test_limit_cycles_are_told_apart_by_period_turns_and_height():
    outcome = _outcomes(
        regime=[LIMIT_CYCLE] * 6 + [UNSETTLED, AT_REST],
        period=[1, 1, 1, 1, 2, 1, np.nan, np.nan],
        winding=[1, 1, 1, 2, 1, 1, 1.2, np.nan],
        apex=[1.50, 1.51, 1.70, 1.50, 1.50, 1.505, 1.5, np.nan],
    )
    index, cycles = distinct_cycles(outcome)
    assert index[[0, 1, 5]].tolist() == [0, 0, 0]
    assert sorted(index[2:5].tolist()) == [1, 2, 3]
    assert index[6:].tolist() == [-1, -1]
    assert cycles["share"].tolist() == [3 / 8, 1 / 8, 1 / 8, 1 / 8]
    assert cycles["turns"][index[3]] == 2
    assert cycles["hops"][index[4]] == 2
    assert cycles["apex_height_m"][index[2]] == pytest.approx(1.7)


def test_no_limit_cycle_at_all():
    index, cycles = distinct_cycles(_outcomes([FAILED, AT_REST], [np.nan] * 2, [np.nan] * 2))
    assert index.tolist() == [-1, -1]
    assert cycles.empty


def test_a_gait_that_two_kinds_of_release_lead_away_from_each_other():
    """Reflex, σ 3, ω 5: high releases end in one turn per high hop, others in two per low hop."""
    saved = SavedController.from_weights(recipe("V-reflex-w4").controller(), np.array([3.0]), 5.0)
    timing = Timing(duration_s=30.0, tick_s=0.002)
    basin = map_basin(saved, np.array([1.05, 2.2]), np.array([0.0, 0.5]), timing=timing)
    number = basin.grid("limit_cycle")
    assert number.shape == (2, 2)
    assert basin.cycles["hops"].tolist() == [1, 1]
    low, high = (basin.cycles.loc[number[row, 0]] for row in range(2))
    assert (high["turns"], low["turns"]) == (1, 2)
    assert high["apex_height_m"] > 2.0 > 1.2 > low["apex_height_m"]


@pytest.mark.thorough
def test_without_an_oscillator_velocities_take_the_place_of_phases():
    controller = recipe("T").controller()
    saved = SavedController.from_weights(controller, np.zeros(controller.n_weights), None)
    basin = map_basin(saved, np.array([1.1, 1.2]), np.array([-1.0, 0.0, 1.0]), timing=TIMING)
    assert basin.frame["velocity_m_per_s"].tolist() == [-1.0, 0.0, 1.0] * 2
    assert set(basin.frame["regime"]) == {"at rest"}
    assert basin.cycles.empty


def _outcomes(regime, period, winding, apex=None) -> Outcome:
    regime = np.asarray(regime)
    return Outcome(
        regime=regime,
        limit_cycle_period=np.asarray(period, float),
        cot_inverse=np.ones(len(regime)),
        cot_inverse_total=np.ones(len(regime)),
        apex_height_m=np.ones(len(regime)) if apex is None else np.asarray(apex),
        hop_rate=np.full(len(regime), 4.0),
        phase_rate=4.0 * np.asarray(winding, float),
    )
