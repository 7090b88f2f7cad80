"""Means with bootstrap intervals: reproducible, honest about what is undefined."""

import math

import numpy as np
import pytest
from scipy.stats import sem, t

from refusals import refused
from tegotae import TegotaeError
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.statistics import (
    FEW,
    LEVEL,
    STUDENT,
    balanced_difference,
    difference,
    interval,
    paired_difference,
    stratified_difference,
)


def test_the_interval_covers_the_true_mean_about_as_often_as_it_says():
    random = np.random.default_rng(1)
    intervals = [interval(random.normal(3.0, 1.0, 30)) for _ in range(200)]
    covered = np.mean([f.low <= 3.0 <= f.high for f in intervals])
    assert 0.88 < covered < 0.99


def test_the_same_values_give_the_same_interval():
    values = np.random.default_rng(0).normal(size=15)
    assert interval(values) == interval(values)


def test_undefined_values_are_counted_and_stay_out():
    result = interval([1.0, math.nan, 3.0, math.nan])
    assert (result.mean, result.count, result.undefined) == (2.0, 2, 2)
    assert result.std == pytest.approx(math.sqrt(2.0))


def test_nothing_defined_is_undefined(recwarn):
    for values in ([], [math.nan, math.nan]):
        result = interval(values)
        assert math.isnan(result.mean)
        assert result.count == 0
    assert not recwarn.list


def test_a_single_value_says_nothing_about_its_spread():
    result = interval([2.5])
    assert result.mean == 2.5
    assert math.isnan(result.std)
    assert math.isnan(result.low)


def test_pairing_removes_what_both_rows_share():
    """Runs that differ by far more than the effect: paired, the effect is certain."""
    random = np.random.default_rng(2)
    base = random.normal(0.0, 10.0, 15)
    better = base + 1.0 + random.normal(0.0, 0.1, 15)
    paired, separate = paired_difference(better, base), difference(better, base)
    assert 0.9 < paired.low < paired.high < 1.1
    assert separate.low < 0.0 < separate.high
    assert paired.mean == pytest.approx(separate.mean)


def test_a_pair_with_an_undefined_member_is_undefined():
    result = paired_difference([1.0, math.nan, 3.0], [0.0, 1.0, math.nan])
    assert (result.mean, result.count, result.undefined) == (1.0, 1, 2)


def test_rows_need_not_be_of_one_length_unless_paired():
    assert difference([1.0, 2.0, 3.0], [1.0, 1.0]).mean == 1.0
    assert math.isnan(difference([1.0, 2.0], []).mean)
    refused("3 values cannot be paired with 2", paired_difference, [1.0, 2.0, 3.0], [1.0, 1.0])


@pytest.mark.parametrize("values", [[[1.0]], "many", [1.0, math.inf], [object()]])
def test_anything_but_a_row_of_numbers_is_refused(values):
    refused("values must be", interval, values)


def test_a_stratified_difference_is_not_fooled_by_which_stratum_is_undefined():
    """No difference in either stratum, but one row is mostly undefined where values are high."""
    random = np.random.default_rng(0)
    low, high = random.normal(0.0, 0.1, (2, 40)), random.normal(5.0, 0.1, (2, 40))
    high[0, 5:] = np.nan
    pooled = difference([*low[0], *high[0]], [*low[1], *high[1]])
    result = stratified_difference([(low[0], low[1]), (high[0], high[1])])
    assert pooled.high < -1.0
    assert -0.1 < result.low < result.high < 0.1
    assert (result.count, result.undefined) == (pooled.count, pooled.undefined) == (125, 35)


def test_a_stratum_without_a_counterpart_is_left_out():
    result = stratified_difference([([1.0, 2.0], [0.0, 1.0]), ([9.0, 9.0], [math.nan, math.nan])])
    assert result.mean == 1.0
    assert (result.count, result.undefined) == (4, 0)
    assert math.isnan(stratified_difference([]).mean)


def test_a_single_value_is_left_out_unless_it_is_exact():
    strata = [([1.0, 2.0], [0.0, 1.0]), ([9.0, 9.0, 9.3], [1.0])]
    assert stratified_difference(strata).mean == pytest.approx(1.0)
    exact = stratified_difference(strata, single_is_exact=True)
    assert exact.mean == pytest.approx((1.0 + 8.1) / 2.0)
    assert exact.low < exact.mean < exact.high
    assert math.isnan(stratified_difference([([9.0], [1.0])], single_is_exact=True).low)


def test_of_a_sample_that_lost_all_but_one_value_nothing_is_known():
    strata = [([1.0, 2.0], [0.0, 1.0]), ([9.0, math.nan], [1.0])]
    assert stratified_difference(strata, single_is_exact=True).mean == pytest.approx(1.0)


@pytest.mark.parametrize("n", [2, 3, 5, 7])
def test_intervals_of_few_values_are_wide_enough(n):
    random = np.random.default_rng(n)
    intervals = [interval(random.normal(3.0, 1.0, n)) for _ in range(1000)]
    assert 0.92 < np.mean([f.low <= 3.0 <= f.high for f in intervals]) < 0.98
    pairs = [difference(random.normal(3.0, 1.0, n), random.normal(0.0, 2.0, 15)) for _ in intervals]
    assert 0.92 < np.mean([f.low <= 3.0 <= f.high for f in pairs]) < 0.98


def test_rows_count_alike_however_long_they_are():
    result = balanced_difference([[1.0] * 50 + [1.2] * 50, [9.0, 9.2]], [[1.0, 2.0]])
    assert result.mean == pytest.approx(5.1 - 1.5)
    assert balanced_difference([[1.0, 1.2], [9.0, 9.2]]).mean == pytest.approx(5.1)
    assert math.isnan(balanced_difference([[1.0, 1.2]], [[3.0]]).mean)


# Ranges.


@pytest.mark.parametrize("values", [[1.0, 1.0, 0.2], [0.0, 0.4], [0.9, 0.1, 1.0, 1.0]])
def test_an_interval_of_a_share_is_one_of_shares(values):
    free, result = interval(values), interval(values, within=(0.0, 1.0))
    assert not 0.0 <= free.low <= free.high <= 1.0
    assert (result.low, result.high) == (max(free.low, 0.0), min(free.high, 1.0))
    assert (result.mean, result.std) == (free.mean, free.std)


def test_what_is_cut_off_an_interval_never_held_the_mean():
    random = np.random.default_rng(0)
    covers = []
    for values in random.beta(0.5, 0.5, (500, 5)):
        free, result = interval(values), interval(values, within=(0.0, 1.0))
        covers.append([i.low <= 0.5 <= i.high for i in (free, result)])
    assert np.mean(covers, axis=0)[0] == np.mean(covers, axis=0)[1]


@pytest.mark.parametrize("n", [3, 20])
def test_intervals_of_metrics_stay_within_what_the_metrics_can_be(n):
    random = np.random.default_rng(n)
    values = {}
    for metric in HOPPING.metrics():
        lowest, highest = metric.range
        # Most at an end of the range, one far from it.
        end, far = (lowest, 1.0) if np.isfinite(lowest) else (highest, -1.0)
        end = end if np.isfinite(end) else 0.0
        values[metric.name] = np.where(np.arange(n) == 0, end + far, end) + 0.0 * random.normal(
            size=n
        )
    for name in values:
        result = interval(values[name], within=HOPPING.range_of(name))
        lowest, highest = HOPPING.range_of(name)
        assert lowest <= result.low <= result.mean <= result.high <= highest


def test_differences_of_shares_stay_between_minus_one_and_one():
    a, b, share = [1.0, 0.9, 0.2], [0.0, 0.0, 0.7], (0.0, 1.0)
    assert paired_difference(a, b).high > 1.0
    assert difference(a, b).high > 1.0
    for result in (
        paired_difference(a, b, within=share),
        difference(a, b, within=share),
        stratified_difference([(a, b)], within=share),
    ):
        assert -1.0 <= result.low < result.high == 1.0
    assert balanced_difference([a], within=share).high == 1.0


def test_a_difference_of_what_has_one_end_has_none():
    a, b, positive = [3.0, 0.0, 0.1], [9.0, 0.0, 0.0], (0.0, math.inf)
    assert difference(a, b, within=positive) == difference(a, b)
    assert paired_difference(a, b, within=positive) == paired_difference(a, b)


@pytest.mark.parametrize("value", [-0.01, 1.44])
def test_a_value_out_of_its_range_is_an_error_and_not_cut(value):
    with pytest.raises(TegotaeError, match=f"hold {value:g}; they must lie between 0 and 1"):
        interval([0.5, value], within=(0.0, 1.0))


@pytest.mark.parametrize("count", range(2, FEW))
def test_an_interval_of_few_values_is_that_of_students_t(count):
    values = np.random.default_rng(count).normal(size=count)
    low, high = t.interval(LEVEL, count - 1, values.mean(), sem(values))
    interval_of_values = interval(values)
    assert interval_of_values.method == STUDENT
    assert (interval_of_values.low, interval_of_values.high) == pytest.approx((low, high), 1e-12)


def test_an_interval_says_how_it_was_found():
    few, many = [1.0, 2.0, 4.0], np.arange(9.0)
    assert interval(few).method == "Student's t"
    assert interval(many).method == "bootstrap"
    assert paired_difference(many, many[::-1]).method == "bootstrap"
    assert difference(many, few).method == balanced_difference([few]).method == "Welch's t"
    assert interval([1.0]).method == difference([1.0], few).method == ""
