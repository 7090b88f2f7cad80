"""Means with bootstrap intervals: reproducible, honest about what is undefined."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tegotae import TegotaeError
from tegotae.metrics import difference, interval, paired_difference, stratified_difference


def test_the_interval_covers_the_true_mean_about_as_often_as_it_says():
    random = np.random.default_rng(1)
    found = [interval(random.normal(3.0, 1.0, 30)) for _ in range(200)]
    covered = np.mean([f.low <= 3.0 <= f.high for f in found])
    assert 0.88 < covered < 0.99


def test_the_same_values_give_the_same_interval_and_another_seed_another():
    values = np.random.default_rng(0).normal(size=15)
    assert interval(values, seed=3) == interval(values, seed=3)
    assert interval(values, seed=3).low != interval(values, seed=4).low


def test_undefined_values_are_counted_and_stay_out():
    found = interval([1.0, math.nan, 3.0, math.nan])
    assert (found.mean, found.count, found.undefined) == (2.0, 2, 2)
    assert found.std == pytest.approx(math.sqrt(2.0))


def test_nothing_defined_is_undefined(recwarn):
    for values in ([], [math.nan, math.nan]):
        found = interval(values)
        assert math.isnan(found.mean)
        assert found.count == 0
    assert not recwarn.list


def test_a_single_value_says_nothing_about_its_spread():
    found = interval([2.5])
    assert found.mean == 2.5
    assert math.isnan(found.std)
    assert math.isnan(found.low)


def test_pairing_removes_what_both_rows_share():
    """Runs that differ by far more than the effect: paired, the effect is certain."""
    random = np.random.default_rng(2)
    base = random.normal(0.0, 10.0, 15)
    better = base + 1.0 + random.normal(0.0, 0.1, 15)
    paired, apart = paired_difference(better, base), difference(better, base)
    assert 0.9 < paired.low < paired.high < 1.1
    assert apart.low < 0.0 < apart.high
    assert paired.mean == pytest.approx(apart.mean)


def test_a_pair_with_an_undefined_member_is_undefined():
    found = paired_difference([1.0, math.nan, 3.0], [0.0, 1.0, math.nan])
    assert (found.mean, found.count, found.undefined) == (1.0, 1, 2)


def test_rows_need_not_be_of_one_length_unless_paired():
    assert difference([1.0, 2.0, 3.0], [1.0, 1.0]).mean == 1.0
    assert math.isnan(difference([1.0, 2.0], []).mean)
    with pytest.raises(TegotaeError, match="3 values cannot be paired with 2"):
        paired_difference([1.0, 2.0, 3.0], [1.0, 1.0])


@pytest.mark.parametrize("values", [[[1.0]], "many", [1.0, math.inf], [object()]])
def test_anything_but_a_row_of_numbers_is_refused(values):
    with pytest.raises(TegotaeError, match="values must be"):
        interval(values)


def test_a_stratified_difference_is_not_fooled_by_which_stratum_is_undefined():
    """No difference in either stratum, but one row is mostly undefined where values are high."""
    random = np.random.default_rng(0)
    low, high = random.normal(0.0, 0.1, (2, 40)), random.normal(5.0, 0.1, (2, 40))
    high[0, 5:] = np.nan
    pooled = difference([*low[0], *high[0]], [*low[1], *high[1]])
    found = stratified_difference([(low[0], low[1]), (high[0], high[1])])
    assert pooled.high < -1.0
    assert -0.1 < found.low < found.high < 0.1
    assert (found.count, found.undefined) == (pooled.count, pooled.undefined) == (125, 35)


def test_a_stratum_without_a_counterpart_is_left_out():
    found = stratified_difference([([1.0, 2.0], [0.0, 1.0]), ([9.0, 9.0], [math.nan, math.nan])])
    assert found.mean == 1.0
    assert (found.count, found.undefined) == (6, 2)
    assert math.isnan(stratified_difference([]).mean)
