"""Readings that agree with what the paper says of V: scores, posterior, and the run over them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tegotae._support.errors import TegotaeError
from tegotae.measures.evaluation import Protocol
from tegotae.simulation.rollout import Timing
from tegotae.studies.paper.calibration.measure import CalibrationGrid, measure
from tegotae.studies.paper.calibration.posterior import distances, narrowed, posterior
from tegotae.studies.paper.calibration.prior import PRIOR, SECTOR_S, candidates, coordinates
from tegotae.studies.paper.calibration.run import calibrate, read_scores
from tegotae.studies.paper.calibration.scores import (
    SCORES,
    VanillaScores,
    quick_loss,
    reflex_stays,
    robust_gain,
    sector_line,
    short,
    slows,
)
from tegotae.studies.paper.multiverse.readings import Reading

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
    assert math.isnan(sector_line(SIGMA, OMEGA, np.full((len(SIGMA), len(OMEGA)), NAN)))


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


def test_vs_gain_serves_all_frequencies_and_not_the_best_one():
    cot = np.zeros((3, len(OMEGA)))
    cot[0, OMEGA == 7.0] = 9.0  # superb at one frequency, at rest at others
    cot[1, np.abs(OMEGA - 7.0) <= 2.0] = 1.0
    assert robust_gain(np.array([1.0, 2.0, 3.0]), OMEGA, cot, 7.0) == 2.0


def test_transients_that_never_end_are_as_long_as_the_episode():
    assert short(np.array([0.0, NAN]), 30.0) == pytest.approx(0.5)


def test_slowing_counts_while_the_actuator_pushes():
    feedback = np.array([[-4.0], [4.0], [-2.0]])
    force = np.array([[1.0], [0.0], [3.0]])
    assert slows(feedback, force, np.array([8.0])) == pytest.approx((0.5 + 0.25) / 2)
    assert math.isnan(slows(feedback, 0.0 * force, np.array([8.0]))), "it never pushes"


# The prior.


def test_candidates_are_bodies_that_can_stand_and_more_add_to_them():
    some = candidates(16)
    assert some == candidates(40)[:16]
    places = np.array([coordinates(each) for each in some])
    assert places.shape == (16, len(PRIOR))
    assert ((places >= 0.0) & (places <= 1.0)).all()
    assert {each.sector_s for each in some} == {None, SECTOR_S}
    with pytest.raises(TegotaeError, match="bodies"):
        candidates(0)


# The posterior.


def test_a_planted_reading_is_found():
    """Scores that are functions of the body: the nearest to the planted one's are near to it."""
    readings = candidates(256)
    places = np.array([coordinates(each) for each in readings])
    continuous = [i for i, choice in enumerate(PRIOR) if not choice.levels]
    mix = np.random.default_rng(0).normal(size=(len(continuous), len(SCORES)))
    scores = 1.0 / (1.0 + np.exp(-(places[:, continuous] - 0.5) @ mix))
    planted = 100
    found = posterior(scores, 0.04, target=scores[planted])
    assert found.accepted[0] == planted
    gaps = np.abs(places - places[planted])[:, continuous].mean(axis=1)
    assert gaps[found.accepted[1:]].mean() < 0.5 * gaps.mean()
    assert (narrowed(places, found.accepted)[continuous] < 0.8).all()


def test_undefined_scores_are_as_far_as_can_be_and_undefined_targets_count_for_none():
    scores = np.array([[1.0, NAN], [1.0, 0.0], [1.0, 0.5]])
    np.testing.assert_allclose(distances(scores), np.sqrt([0.5, 0.5, 0.125]))
    np.testing.assert_allclose(distances(scores, np.array([1.0, NAN])), 0.0)


@pytest.mark.parametrize("share", [0.0, 1.5, 0.001])
def test_a_share_that_accepts_none_or_more_than_all_is_refused(share):
    with pytest.raises(TegotaeError, match="share is"):
        posterior(np.ones((10, 2)), share)


def test_what_the_scores_say_nothing_about_stays_as_wide_as_before():
    places = np.random.default_rng(0).uniform(size=(4000, 2))
    found = posterior(places[:, :1], 0.05, target=np.array([0.5]))
    narrow = narrowed(places, found.accepted)
    assert narrow[0] < 0.2
    assert narrow[1] == pytest.approx(1.0, abs=0.15)


# The run.


def made_up(reading: Reading) -> VanillaScores:
    return VanillaScores(*np.linspace(0.0, 1.0, len(SCORES)) * reading.damping_ratio)


def test_a_run_goes_on_where_it_was_and_measures_nothing_twice(tmp_path):
    path, asked = tmp_path / "scores.csv", []

    def scorer(reading: Reading) -> VanillaScores:
        asked.append(reading)
        if len(asked) == 4:
            raise KeyboardInterrupt
        return made_up(reading)

    with pytest.raises(KeyboardInterrupt):
        calibrate(path, 6, scorer=scorer)
    assert len(read_scores(path)) == 3
    whole = calibrate(path, 6, scorer=scorer)
    assert asked[4:] == candidates(6)[3:]
    np.testing.assert_allclose(whole, np.array([made_up(each) for each in candidates(6)]))
    np.testing.assert_allclose(read_scores(path), whole)
    np.testing.assert_allclose(calibrate(path, 2, scorer=scorer), whole[:2])
    assert len(read_scores(path)) == 6, "fewer than are there take none away"


def test_a_table_of_other_readings_is_refused(tmp_path):
    path = tmp_path / "scores.csv"
    calibrate(path, 2, scorer=made_up)
    head, first, second = path.read_text().splitlines()
    path.write_text("\n".join([head, second, first]) + "\n")
    with pytest.raises(TegotaeError, match="other readings"):
        calibrate(path, 3, scorer=made_up)


@pytest.mark.thorough
def test_a_reading_is_measured_on_the_engine():
    found = measure(Reading(), TINY)
    assert all(math.isnan(x) or 0.0 <= x <= 1.0 for x in found)
    assert 0.0 < found.slows < 1.0
    assert np.isfinite([found.settles, found.short_t0, found.quick_loss]).all()
    assert found == measure(Reading(), TINY)
    assert measure(Reading(natural_frequency=3.0, mass_kg=0.5), TINY) != found
