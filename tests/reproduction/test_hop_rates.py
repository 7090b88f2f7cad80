"""Hop rates over ω, on made-up episodes."""

import numpy as np
import pytest

from records import made_up
from research.reproduction.hop_rates import best_hop_rate, nearer_resonance, rate_slope
from research.reproduction.plan import plan
from research.reproduction.table import tabulate, tabulate_sampled

OMEGA = np.array([2.0, 3.0, 4.0, 5.0, 6.0])


def test_a_gait_that_follows_has_a_slope_of_one_and_one_that_does_not_none():
    rates = np.stack([OMEGA + 0.3, np.full(5, 4.4), 10.0 - OMEGA])
    np.testing.assert_allclose(rate_slope(OMEGA, rates), [1.0, 0.0, -1.0], atol=1e-12)


def test_unsettled_episodes_are_left_out_and_two_make_no_slope():
    rates = np.array([[2.0, np.nan, 4.0, 5.0, np.nan], [2.0, 3.0, np.nan, np.nan, np.nan]])
    np.testing.assert_allclose(rate_slope(OMEGA, rates), [1.0, np.nan])
    assert np.isnan(rate_slope(np.full(5, np.nan), np.tile(OMEGA, (2, 1)))).all()


def test_a_gait_at_the_bodys_best_rate_is_nearer_to_it_by_all_of_omegas_distance():
    best = best_hop_rate()
    assert 2.0 < best < 5.0
    omega = best + np.array([1.0, 3.0])
    differences = nearer_resonance(omega, np.array([[best, best], omega, [np.nan, np.nan]]))
    np.testing.assert_allclose(differences, [2.0, -2.0, np.nan])


def test_the_studys_table_has_them_and_so_has_that_of_the_drawn_controllers():
    record = made_up(plan("smoke").units[0])
    for table in (tabulate([record]), tabulate_sampled([record])):
        assert {"rate_slope", "nearer_resonance", "at_rest_share"} <= set(table.metrics)
    expected = np.nanmean(np.asarray(record.sampled["cot_inverse"], float), axis=1)
    assert tabulate_sampled([record])["cot_inverse"] == pytest.approx(expected)
