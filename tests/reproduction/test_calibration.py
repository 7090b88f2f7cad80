"""Readings that agree with what the paper says of V: scores, posterior, and the run over them."""

import itertools
import math

import numpy as np
import pytest

from refusals import refused
from research.reproduction.calibration.measure import CalibrationGrid, measure_reading
from research.reproduction.calibration.posterior import (
    STRICTNESS,
    distances,
    meeting_ratio,
    met,
    narrowed,
    posterior,
    representative,
    shortfalls,
)
from research.reproduction.calibration.prior import PRIOR, SECTOR_S, candidates, coordinates
from research.reproduction.calibration.run import calibrate, read_scores
from research.reproduction.calibration.scores import (
    SCORES,
    VanillaScores,
    quick_loss,
    reflex_stays,
    sector_line,
    slows,
    transient_score,
    tuned_gain,
)
from research.reproduction.readings.readings import Reading
from tegotae.measures.evaluation import Protocol
from tegotae.simulation.rollout import Timing

OMEGA = np.linspace(3.0, 9.0, 25)
SIGMA = np.linspace(0.0, 12.0, 49)
NAN = float("nan")

TINY = CalibrationGrid(
    gains=tuple(np.linspace(0.5, 10.0, 6).tolist()),
    omegas=(6.0, 7.0, 8.0, 9.0, 10.0),
    omega_t=(8.0,),
    timing=Timing(duration_s=8.0, tick_s=0.004),
    protocol=Protocol(
        undisturbed_s=8.0, disturbed_s=4.0, offsets=(0.0,), clamped_phases=1, tick_s=0.004
    ),
)


def hill(of_gain, of_omega=None, width: float = 0.8) -> np.ndarray:
    """A map whose best gain is a function of ω, of a height that is another."""
    best = np.array([of_gain(w) for w in OMEGA])
    tall = np.ones_like(OMEGA) if of_omega is None else np.array([of_omega(w) for w in OMEGA])
    return tall * np.exp(-(((SIGMA[:, None] - best) / width) ** 2))


# Scores.


def test_a_ridge_on_a_rising_line_agrees_and_on_a_falling_one_does_not():
    assert sector_line(SIGMA, OMEGA, hill(lambda w: 1.2 * w - 2.0)) > 0.99
    assert sector_line(SIGMA, OMEGA, hill(lambda w: 12.0 - w)) == 0.0
    bent = sector_line(SIGMA, OMEGA, hill(lambda w: 6.0 + 3.0 * math.sin(2.0 * w)))
    assert bent < 0.5
    assert sector_line(SIGMA, OMEGA, np.full((len(SIGMA), len(OMEGA)), NAN)) == 0.0


def test_a_line_over_half_of_the_frequencies_is_half_a_line():
    rising = hill(lambda w: 1.2 * w - 2.0)
    rising[:, OMEGA < 6.0] = NAN
    half = float((OMEGA >= 6.0).mean())
    assert sector_line(SIGMA, OMEGA, rising) == pytest.approx(half, abs=0.01)


def test_a_resonance_that_no_gain_moves_agrees():
    still = hill(lambda w: 6.0, lambda w: math.exp(-((w - 5.0) ** 2)), width=20.0)
    assert reflex_stays(OMEGA, still) == pytest.approx(1.0)
    moves = hill(lambda w: 1.9 * w - 5.5)  # each gain has its own best frequency
    assert reflex_stays(OMEGA, moves) < 0.2


def test_what_is_lost_a_rad_per_s_away_is_counted_and_rest_is_all():
    narrow = hill(lambda w: 2.0 * w - 6.0, width=0.2)
    assert quick_loss(OMEGA, narrow) > 0.95
    flat = np.ones((len(SIGMA), len(OMEGA)))
    assert quick_loss(OMEGA, flat) == 0.0
    flat[:, OMEGA > 6.0] = NAN
    assert 0.0 < quick_loss(OMEGA, flat) < 1.0


def test_vs_gain_is_the_best_at_its_frequency_or_the_one_that_serves_all():
    sigma, over = np.array([1.0, 2.0, 3.0]), [5.0, 6.0, 7.0, 8.0, 9.0]
    fitness = np.full((3, len(OMEGA)), -4.0)
    fitness[0, OMEGA == 7.0] = 9.0  # superb at one frequency, at rest at others
    fitness[1, np.abs(OMEGA - 7.0) <= 2.0] = 1.0
    fitness[2] = -np.inf  # its leg breaks
    assert tuned_gain(sigma, OMEGA, fitness, [7.0]) == 1.0
    assert tuned_gain(sigma, OMEGA, fitness, over) == 2.0


def test_transients_that_never_end_are_as_long_as_the_episode():
    assert transient_score(np.array([0.0, NAN]), 30.0) == pytest.approx(0.5)


def test_slowing_counts_while_the_actuator_pushes():
    feedback = np.array([[-4.0], [4.0], [-2.0]])
    force = np.array([[1.0], [0.0], [3.0]])
    assert slows(feedback, force, np.array([8.0])) == pytest.approx((0.5 + 0.25) / 2)
    assert math.isnan(slows(feedback, 0.0 * force, np.array([8.0]))), "it never pushes"


# The prior.


def test_candidates_are_bodies_that_can_stand_and_more_add_to_them():
    some = candidates(16)
    assert some == candidates(40)[:16]
    places = np.array([coordinates(reading) for reading in some])
    assert places.shape == (16, len(PRIOR))
    assert ((places >= 0.0) & (places <= 1.0)).all()
    assert {reading.sector_s for reading in some} == {None, SECTOR_S}
    refused("bodies", candidates, 0)


# The posterior.


def test_a_planted_reading_is_found():
    """Scores that are functions of the body: the nearest to the planted one's are near to it."""
    readings = candidates(1024)
    places = np.array([coordinates(reading) for reading in readings])
    continuous = [i for i, choice in enumerate(PRIOR) if not choice.levels]
    mix = np.random.default_rng(0).normal(size=(len(continuous), len(SCORES)))
    scores = 1.0 / (1.0 + np.exp(-(places[:, continuous] - 0.5) @ mix))
    planted = 100
    estimate = posterior(distances(scores, scores[planted]), 0.01)
    assert estimate.accepted[0] == planted
    assert estimate.weights.argmax() == 0
    gaps = np.abs(places - places[planted])[:, continuous].mean(axis=1)
    assert gaps[estimate.accepted[1:]].mean() < 0.75 * gaps.mean()
    assert narrowed(places, estimate)[continuous].mean() < 0.8


def test_a_planted_reading_is_found_by_one_that_meets_every_statement():
    """Readings that meet all levels have no distance, whatever they have beyond them."""
    scores = np.random.default_rng(1).uniform(0.0, 0.6, (200, len(SCORES)))
    planted, levels = 77, STRICTNESS[1].target
    scores[planted] = 1.0
    estimate = posterior(shortfalls(scores, levels), 0.05)
    assert estimate.accepted[0] == planted
    assert estimate.distance[planted] == 0.0
    assert met(scores, levels).all(axis=1).nonzero()[0].tolist() == [planted]


def test_a_stricter_reader_accepts_nothing_that_a_lenient_one_does_not():
    scores = np.random.default_rng(2).uniform(size=(300, len(SCORES)))
    by = [met(scores, criterion.target) for criterion in STRICTNESS]
    for lenient, strict in itertools.pairwise(by):
        assert (strict <= lenient).all()


def test_statements_that_exclude_each_other_are_never_met_together():
    first = np.repeat([1.0, 0.0], 50)
    scores = np.stack([first, 1.0 - first, np.tile([1.0, 0.0], 50)], axis=1)
    ratios = meeting_ratio(scores, np.full(3, 0.5))
    assert ratios[0, 1] == 0.0
    assert ratios[0, 2] == pytest.approx(1.0)
    assert ratios[0, 0] == pytest.approx(2.0)
    assert np.isnan(meeting_ratio(np.zeros((4, 2)), np.full(2, 0.5))).all(), "none is ever met"


def test_weights_fall_with_the_distance_and_one_far_off_counts_nothing():
    estimate = posterior(np.array([0.1, 0.2, 0.3, 0.4]), 0.75)
    assert estimate.accepted.tolist() == [0, 1, 2]
    assert estimate.threshold == 0.4
    assert (np.diff(estimate.weights) < 0.0).all()
    assert estimate.weights.sum() == pytest.approx(1.0)
    assert 1.0 < estimate.effective < 3.0
    constant = posterior(np.zeros(10), 0.5)
    np.testing.assert_allclose(constant.weights, 0.2)


def test_representatives_are_different_readings_that_lie_as_the_posterior_does():
    places = np.random.default_rng(3).uniform(size=(400, 2))
    estimate = posterior(np.linalg.norm(places - 0.5, axis=1), 0.25)
    some = representative(estimate, places, 16, tries=200)
    assert len(set(some)) == 16
    assert set(some) <= set(estimate.accepted)
    np.testing.assert_allclose(
        places[some].mean(axis=0), estimate.weights @ places[estimate.accepted], atol=0.05
    )
    refused("cannot be drawn", representative, estimate, places, 101)


def test_undefined_scores_are_as_far_as_can_be_and_undefined_targets_count_for_none():
    scores = np.array([[1.0, NAN], [1.0, 0.0], [1.0, 0.5]])
    np.testing.assert_allclose(distances(scores), np.sqrt([0.5, 0.5, 0.125]))
    np.testing.assert_allclose(distances(scores, np.array([1.0, NAN])), 0.0)


@pytest.mark.parametrize("share", [0.0, 1.5, 0.001])
def test_a_share_that_accepts_none_or_more_than_all_is_refused(share):
    refused("share is", posterior, np.ones(10), share)


def test_what_the_scores_say_nothing_about_stays_as_wide_as_before():
    places = np.random.default_rng(0).uniform(size=(4000, 2))
    estimate = posterior(distances(places[:, :1], np.array([0.5])), 0.05)
    narrow = narrowed(places, estimate)
    assert narrow[0] < 0.2
    assert narrow[1] == pytest.approx(1.0, abs=0.15)


# The run.


def made_up(reading: Reading) -> VanillaScores:
    return VanillaScores(*np.linspace(0.0, 1.0, len(SCORES)) * reading.damping_ratio)


def test_a_run_goes_on_where_it_was_and_measures_nothing_twice(tmp_path):
    path, measured = tmp_path / "scores.csv", []

    def scorer(reading: Reading) -> VanillaScores:
        measured.append(reading)
        if len(measured) == 4:
            raise KeyboardInterrupt
        return made_up(reading)

    with pytest.raises(KeyboardInterrupt):
        calibrate(path, range(6), scorer=scorer)
    assert len(read_scores(path)) == 3
    scores = calibrate(path, range(6), scorer=scorer)
    assert len(measured) == 4 + 3
    expected = np.array([made_up(candidate) for candidate in candidates(6)])
    np.testing.assert_allclose(scores, expected, rtol=1e-3)
    np.testing.assert_allclose(list(read_scores(path).values()), expected, rtol=1e-3)
    np.testing.assert_allclose(calibrate(path, [4, 1], scorer=scorer), expected[[4, 1]], rtol=1e-3)
    assert len(read_scores(path)) == 6, "fewer than are there take none away"


def test_a_table_of_other_readings_is_refused(tmp_path):
    path = tmp_path / "scores.csv"
    calibrate(path, range(2), scorer=made_up)
    head, first, second = path.read_text().splitlines()
    path.write_text("\n".join([head, first, second.replace("1,", "0,", 1)]) + "\n")
    refused("other readings", calibrate, path, range(3), scorer=made_up)


@pytest.mark.thorough
def test_a_reading_is_measured_on_the_engine():
    scores = measure_reading(Reading(), TINY)
    assert all(math.isnan(x) or 0.0 <= x <= 1.0 for x in scores)
    assert 0.0 < scores.slows < 1.0
    assert np.isfinite([scores.settles, scores.short_t0, scores.quick_loss]).all()
    assert scores == measure_reading(Reading(), TINY)
    assert measure_reading(Reading(natural_frequency=3.0, mass_kg=0.5), TINY) != scores
