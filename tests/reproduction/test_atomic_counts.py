"""Every way to count the same records, on made-up tables whose effects are known."""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from research.reproduction.claims.atomic import ALIKE, LESS, MORE, AtomicClaim
from research.reproduction.claims.counting import (
    AT_REST,
    BEST,
    DROPPED,
    FIGURE_2,
    SAMPLED,
    WORST,
    Count,
    counts,
    metric_per_run,
    with_sampled,
)
from research.reproduction.claims.effects import (
    ArchitectureGroup,
    Correlation,
    Difference,
    DoubleDifference,
    Effect,
    OfGainMap,
    OfGaits,
    OfTrainings,
)
from research.reproduction.claims.estimates import NOT_KNOWN, EffectEstimate, estimate_effect
from research.reproduction.claims.findings import (
    NOT_MEASURED,
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
    findings,
    verdict,
)
from research.reproduction.claims.kept import measure_kept
from research.reproduction.claims.random_effects import complete, crossed
from research.reproduction.claims.resampling import Resampled
from research.reproduction.table import StudyTable
from tegotae.measures.evaluation import Protocol

V, VG, T = ArchitectureGroup(("V",)), ArchitectureGroup(("VG",)), ArchitectureGroup(("T",))
VG_OVER_V = Difference("cot_inverse", VG, V)
NAN = float("nan")
FEW = 200


def rows(*models: tuple, runs: int = 4, **columns_added) -> StudyTable:
    """A table of (architecture, actuation, ω_t, CoT⁻¹ of the runs) with settled runs."""
    columns = {
        name: []
        for name in (
            *("model", "architecture", "observation", "actuation", "omega_t", "run"),
            *("best_fitness", "cot_inverse", "limit_cycle_share", "failed_share"),
        )
    }
    for architecture, actuation, omega, values in models:
        for run, value in enumerate(np.broadcast_to(values, runs)):
            name = f"{architecture}-{actuation}-w{omega:g}"
            row = (name, architecture, "F", actuation, omega, run, float(run), value, 1.0, 0.0)
            for column, entry in zip(columns.values(), row, strict=True):
                column.append(entry)
    table = {name: np.array(column) for name, column in columns.items()}
    return StudyTable(table | {name: np.array(column) for name, column in columns_added.items()})


def effect(
    table: StudyTable, count: Count | None = None, measured: Effect = VG_OVER_V
) -> EffectEstimate:
    return estimate_effect(measured, Resampled(table, FEW), count or Count())


def test_architectures_are_compared_at_equal_frequency_and_input():
    table = rows(
        ("V", "sector", 4.0, 1.0),
        ("V", "reflex", 4.0, 5.0),
        ("VG", "sector", 4.0, 1.5),  # there is no VG by reflex: V's 5.0 does not count
        ("V", "sector", 8.0, 0.1),
        ("VG", "tphi", 8.0, 0.3),
    )
    assert effect(table).effect == pytest.approx((0.5 + 0.2) / 2)
    assert effect(table, Count(omega_t="4")).effect == pytest.approx(0.5)
    assert effect(table, Count(omega_t="8")).effect == pytest.approx(0.2)
    assert effect(table).size == pytest.approx(0.55), "beside it stands V's own level"


def test_as_in_figure_2_all_models_of_an_architecture_are_pooled_and_normalised():
    table = rows(
        ("V", "sector", 4.0, 1.0),
        ("V", "reflex", 4.0, 5.0),
        ("VG", "sector", 4.0, 1.5),
        ("V", "sector", 8.0, 0.0),
    )
    estimate = effect(table, Count(average=FIGURE_2))
    assert estimate.effect == pytest.approx((1.5 - 2.0) / 5.0)


def test_the_best_run_is_that_of_the_highest_fitness_in_training():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, [9.0, 2.0, 2.0, 3.0]))
    assert effect(table).effect == pytest.approx(3.0)
    assert effect(table, Count(run=BEST)).effect == pytest.approx(2.0)


def test_runs_that_share_the_highest_fitness_count_with_their_mean():
    table = rows(("V", "sector", 4.0, [1.0, 3.0, 1.0, 3.0]), ("VG", "sector", 4.0, 4.0))
    table.columns["best_fitness"][:4] = 0.5
    assert effect(table, Count(run=BEST)).effect == pytest.approx(2.0)


def test_unsettled_episodes_are_dropped_or_count_as_the_worst():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, 1.5))
    table.columns["limit_cycle_share"] = np.repeat([1.0, 0.4], 4)
    assert effect(table).effect == pytest.approx(0.5)
    assert effect(table, Count(unsettled=WORST)).effect == pytest.approx(0.4 * 1.5 - 1.0)


def test_where_a_table_does_not_say_how_many_rest_both_bounds_are_ways_to_count():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, 1.5))
    table.columns["limit_cycle_share"] = np.repeat([1.0, 0.4], 4)
    table.columns["failed_share"] = np.repeat([0.0, 0.2], 4)
    estimate = effect(table, Count(unsettled=AT_REST))
    assert estimate.effect == pytest.approx(0.8 * 1.5 - 1.0), "only those that fell are not at rest"


def test_transients_that_never_end_are_as_long_as_the_episode():
    table = rows(
        ("V", "sector", 4.0, 1.0),
        t0_s=[5.0, 5.0, NAN, 5.0],
        t1_s=[2.0, 2.0, NAN, NAN],
        recovery_share=[1.0, 0.5, NAN, 0.0],
    )
    table.columns["limit_cycle_share"] = np.array([1.0, 0.5, 0.0, 1.0])
    times = Protocol(undisturbed_s=30.0, disturbed_s=20.0)
    t0 = metric_per_run(table, "t0_s", WORST, times)["t0_s"]
    t1 = metric_per_run(table, "t1_s", WORST, times)["t1_s"]
    np.testing.assert_allclose(t0, [5.0, 17.5, 30.0, 5.0])
    np.testing.assert_allclose(t1, [2.0, 0.25 * 2.0 + 0.75 * 20.0, 20.0, 20.0])
    np.testing.assert_allclose(metric_per_run(table, "t0_s", DROPPED, times)["t0_s"], table["t0_s"])


def test_a_table_of_episodes_counts_each_of_them():
    table = rows(("VG", "sector", 4.0, [1.0, 0.0, NAN, NAN]))  # settled, at rest, unsettled twice
    table.columns["run"] = np.zeros(4, int)
    table.columns["omega"] = np.array([3.0, 4.0, 5.0, 6.0])
    assert metric_per_run(table, "cot_inverse", DROPPED)["cot_inverse"] == pytest.approx([0.5])
    assert metric_per_run(table, "cot_inverse", WORST)["cot_inverse"] == pytest.approx([0.25])
    assert AT_REST not in {count.unsettled for count in counts(table)}


def test_a_controller_drawn_from_the_best_runs_distribution_is_a_way_to_count():
    plain = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, [1.0, 2.0, 3.0, 4.0]))
    assert SAMPLED not in {count.run for count in counts(plain)}
    drawn = {name: np.concatenate([column, column]) for name, column in plain.columns.items()}
    drawn["sample"] = np.repeat([0, 1], 8)
    drawn["cot_inverse"] = np.concatenate(
        [plain["cot_inverse"], np.full(4, 1.0), [0.0, 0.0, 0.0, 2.5]]
    )
    table = StudyTable(drawn)
    assert SAMPLED in {count.run for count in counts(table)}
    assert effect(table, Count(run=SAMPLED)).effect == pytest.approx(1.5)
    assert effect(table, Count(run=BEST)).effect == pytest.approx(3.0)


def test_the_single_network_is_compared_with_every_design():
    table = rows(("V", "sector", 4.0, 1.0), ("V", "sector", 8.0, 0.4), ("T", "tF", NAN, 0.9))
    difference = Difference("cot_inverse", T, V)
    assert effect(table, measured=difference).effect == pytest.approx(0.2)
    assert effect(table, Count(omega_t="8"), difference).effect == pytest.approx(0.5)
    assert effect(table, Count(average=FIGURE_2), difference).effect == pytest.approx(0.2 / 0.6)


def test_the_lowest_of_others_is_that_over_all_designs():
    table = rows(
        ("V", "sector", 4.0, 1.0),
        ("V", "sector", 8.0, 1.0),
        ("VG", "sector", 4.0, 0.9),
        ("VG", "sector", 8.0, 0.3),
        ("VT", "tphi", 4.0, 0.0),
        ("VT", "tphi", 8.0, 2.0),
    )
    difference = Difference("cot_inverse", V, ArchitectureGroup(("VG", "VT")), lowest=True)
    assert effect(table, measured=difference).effect == pytest.approx(0.4), "VG is lower on average"


def test_a_gain_is_one_difference_less_another():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, 1.6), ("T", "tF", NAN, 1.2))
    difference = DoubleDifference("cot_inverse", (VG, V), (T, V))
    assert effect(table, measured=difference).effect == pytest.approx(0.4)


def test_metrics_are_correlated_over_models_not_over_runs():
    number = np.arange(12.0)
    models = [(f"V{i}", "sector", 4.0, i) for i in range(1, 13)]
    table = rows(*models, t0_s=np.repeat(-number, 4) + np.tile([0.0, 1.0, 2.0, 3.0], 12))
    estimate = effect(table, measured=Correlation("cot_inverse", "t0_s"))
    assert estimate.effect == pytest.approx(-1.0)
    few = rows(*models[:5], t0_s=np.repeat(-number[:5], 4))
    assert not effect(few, measured=Correlation("cot_inverse", "t0_s")).is_known, (
        "of five models chance"
    )


def test_intervals_are_over_runs():
    spread = rows(("V", "sector", 4.0, [0.0, 2.0, 0.0, 2.0]), ("VG", "sector", 4.0, 1.5))
    estimate = effect(spread)
    assert estimate.low < 0.0 < 0.5 < estimate.high
    constant = effect(rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, 1.5)))
    assert constant.low == constant.high == pytest.approx(0.5)
    assert effect(spread) == effect(spread), "the draws are the same every time"


def test_beside_it_stands_the_interval_over_designs_and_frequencies():
    gains = np.array([[0.3, 0.1], [0.5, 0.2], [0.4, 0.3]])
    places = [(d, w) for d in ("sector", "reflex", "both") for w in (4.0, 8.0)]
    table = rows(
        *(("V", *place, 1.0) for place in places),
        *(("VG", *p, 1.0 + gain) for p, gain in zip(places, gains.ravel(), strict=True)),
    )
    estimate = effect(table)
    assert (estimate.designs_low, estimate.designs_high) == pytest.approx(crossed(gains))
    assert (estimate.low, estimate.high) == pytest.approx((0.3, 0.3)), "runs are alike"
    single = effect(table, Count(omega_t="4"))
    half = stats.sem(gains[:, 0]) * stats.t.ppf(0.975, 2)
    assert single.designs_high - single.effect == pytest.approx(half), "of one ω_t it is Student's"
    assert not effect(table, Count(average=FIGURE_2)).over_designs.is_known
    assert verdict(CLAIM, estimate) == REPRODUCED
    assert verdict(CLAIM, estimate.over_designs) == TOO_SMALL


def test_designs_or_frequencies_without_a_number_have_no_say_in_that_interval():
    gains = np.array([[0.3, 0.1, NAN], [0.5, 0.2, NAN], [NAN, NAN, NAN]])
    np.testing.assert_array_equal(complete(gains), gains[:2, :2])
    assert np.isnan(crossed(complete(gains[2:]))).all()
    assert np.isnan(crossed(gains[:1, :1])).all(), "one difference has no spread"


def test_a_correlation_varies_over_frequencies():
    number = np.arange(12.0)
    models = [(f"V{i}", "sector", w, i) for w in (4.0, 8.0) for i in range(1, 13)]
    table = rows(*models, t0_s=np.repeat(np.concatenate([number, -number]), 4))
    estimate = effect(table, measured=Correlation("cot_inverse", "t0_s"))
    assert estimate.effect == pytest.approx(0.0)
    assert (estimate.designs_low, estimate.designs_high) == (-1.0, 1.0), "no further than it can be"


def test_what_the_table_does_not_have_is_not_measured():
    table = rows(("V", "sector", 4.0, 1.0))
    assert effect(table) == NOT_KNOWN, "no VG"
    assert effect(table, measured=Difference("t9", V, None)) == NOT_KNOWN
    assert effect(table, measured=OfGaits("feedback_share", V)) == NOT_KNOWN
    table.columns["feedback_share"] = np.full(4, 0.25)
    assert effect(table, measured=OfGaits("feedback_share", V)).effect == 0.25


CLAIM = AtomicClaim(name="x", title="x", words="", section="", effect=VG_OVER_V, sign=MORE)


@pytest.mark.parametrize(
    ("sign", "estimate", "word"),
    [
        (MORE, EffectEstimate(0.2, 0.1, 0.3), REPRODUCED),
        (MORE, EffectEstimate(-0.2, -0.3, -0.1), OPPOSITE),
        (MORE, EffectEstimate(0.2, -0.1, 0.3), TOO_SMALL),
        (LESS, EffectEstimate(-0.2, -0.3, -0.1), REPRODUCED),
        (LESS, EffectEstimate(0.2, 0.1, 0.3), OPPOSITE),
        (ALIKE, EffectEstimate(0.2, -0.1, 0.24, size=1.0), REPRODUCED),
        (ALIKE, EffectEstimate(-0.2, -0.21, 0.1, size=1.0), TOO_SMALL),
        (ALIKE, EffectEstimate(-0.3, -0.4, -0.21, size=1.0), OPPOSITE),
        (ALIKE, EffectEstimate(0.3, 0.26, 0.4, size=1.0), OPPOSITE),
        (MORE, NOT_KNOWN, NOT_MEASURED),
    ],
)
def test_a_verdict_is_the_sign_of_the_interval(sign, estimate, word):
    assert verdict(dataclasses.replace(CLAIM, sign=sign), estimate) == word


def test_what_a_body_was_chosen_to_agree_with_is_selected_for_and_not_reproduced():
    up, down = EffectEstimate(0.2, 0.1, 0.3), EffectEstimate(-0.2, -0.3, -0.1)
    finding = Finding(CLAIM, {Count(): up, Count(run=BEST): up}, selected=True)
    assert (finding.outcome, finding.is_robust) == (SELECTED_FOR, True)
    against = Finding(CLAIM, {Count(): down, Count(run=BEST): down}, selected=True)
    assert against.outcome == OPPOSITE, "that the choice did not succeed is a result"
    turns = Finding(CLAIM, {Count(): up, Count(run=BEST): down}, selected=True)
    assert turns.outcome == "depends on which run"


def test_a_claim_on_potential_counts_the_best_run_alone():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, [9.0, 2.0, 2.0, 3.0]))
    table.columns["model"] = np.repeat(["V-sector-w4", "VG-gF-sector-w4"], 4)
    potential = dataclasses.replace(CLAIM, run=BEST)
    (finding,) = findings(table, claims=[potential], resamples=FEW)
    assert {count.run for count in finding.by_count} == {BEST}
    (single,) = findings(table, claims=[potential], resamples=FEW, options=[Count()])
    assert single.by_count[Count(run=BEST)].effect == pytest.approx(2.0)


def test_what_turns_with_one_choice_depends_on_it():
    up, down = EffectEstimate(0.2, 0.1, 0.3), EffectEstimate(-0.2, -0.3, -0.1)
    turns = Finding(CLAIM, {Count(): up, Count(unsettled=WORST): down})
    assert turns.outcome == "depends on unsettled episodes"
    assert not turns.is_robust
    finding = Finding(CLAIM, {Count(): up, Count(unsettled=WORST, run=BEST): down})
    assert finding.outcome == "depends on several choices together"


def test_what_all_counts_decide_alike_is_robust():
    up, small = EffectEstimate(0.2, 0.1, 0.3), EffectEstimate(0.2, -0.1, 0.3)
    assert Finding(CLAIM, {Count(): up, Count(run=BEST): up}).is_robust
    some = Finding(CLAIM, {Count(): up, Count(run=BEST): small})
    assert not some.is_robust
    assert some.outcome == "reproduced, or too small to tell"
    assert Finding(CLAIM, {Count(): small}).outcome == TOO_SMALL
    assert not Finding(CLAIM, {Count(): up}).is_robust, "one way to count shows nothing of others"


def test_experiments_without_a_table_are_not_measured(tmp_path):
    for effect_of in (OfGainMap("slope", "sector"), OfTrainings("figure3.csv", "x", "a", "b")):
        assert measure_kept(effect_of, None) == measure_kept(effect_of, tmp_path) == NOT_KNOWN


def test_a_ridge_on_a_line_has_its_slope_and_is_explained(tmp_path):
    lines = ["actuation,omega_rad_per_s,best_sigma_rad_per_s_n,censored"]
    lines += [f"sector,{w},{2.0 * w},0" for w in range(3, 10)]
    lines += [f"reflex,{w},{(-1.0) ** w},0" for w in range(3, 10)]
    (tmp_path / "gain_map.ridge.csv").write_text("\n".join(lines) + "\n")
    slope = measure_kept(OfGainMap("slope", "sector"), tmp_path)
    assert (slope.effect, slope.size) == (pytest.approx(2.0), pytest.approx(1.0))
    less = measure_kept(OfGainMap("r_squared", "reflex", "sector"), tmp_path)
    assert less.effect < 0.0
    assert less.size == pytest.approx(1.0)
    assert measure_kept(OfGainMap("loss", "both"), tmp_path) == NOT_KNOWN, "the ridge has none"


def test_a_resonance_that_no_gain_moves_is_compared_with_one_that_moves(tmp_path):
    lines = ["actuation,sigma_rad_per_s_n,best_omega_rad_per_s"]
    lines += [f"sector,{gain},{2.0 + gain}" for gain in range(8)]
    lines += [f"reflex,{gain},6.0" for gain in range(8)]
    (tmp_path / "gain_map.resonance.csv").write_text("\n".join(lines) + "\n")
    estimate = measure_kept(OfGainMap("resonance_shift", "reflex", "sector"), tmp_path)
    assert estimate.effect == pytest.approx(-np.std(range(8)))
    assert estimate.low < estimate.effect < estimate.high < 0.0


def test_a_loss_is_that_of_both_actuations_and_may_be_a_gain(tmp_path):
    lines = ["actuation,omega_rad_per_s,cot_inverse_a_lost"]
    lines += [f"sector,{omega},{0.1 * (omega % 3)}" for omega in range(9)]
    lines += [f"reflex,{omega},-0.3" for omega in range(30)]
    (tmp_path / "gain_map.loss.csv").write_text("\n".join(lines) + "\n")
    estimate = measure_kept(OfGainMap("loss", "both"), tmp_path)
    assert estimate.effect == pytest.approx(-0.1)
    assert estimate.high < 0.0


def test_more_parameters_are_compared_at_equal_settings(tmp_path):
    table = ["way,parameters,untrained_fitness,fitness"]
    for method, gain in (("a", 0.0), ("b", 1.0)):
        table += [f"{method},96,-5,{1.0 + gain + 0.01 * i}" for i in range(3)]
        table += [f"{method},256,-5,{0.5 + gain + 0.01 * i}" for i in range(3)]
    table.append("b,256,-5,-1000000")  # failed: counts as untrained
    (tmp_path / "parameter_limit.csv").write_text("\n".join(table) + "\n")
    trainings = OfTrainings("parameter_limit.csv", "fitness", "more than 128", "at most 128")
    expected = np.mean([-0.5, (3 * 1.51 - 5.0) / 4 - 2.01])
    assert measure_kept(trainings, tmp_path).effect == pytest.approx(expected)


def test_a_study_of_the_papers_models_is_found_for_every_claim():
    from research.reproduction.claims.atomic import ATOMIC_CLAIMS

    table = rows(("V", "sector", 4.0, 1.0))
    table.columns["model"] = np.array(["V-sector-w4"] * 4)
    results = findings(table, resamples=FEW, options=[Count()])
    assert [finding.claim for finding in results] == list(ATOMIC_CLAIMS)


def test_a_table_that_says_how_many_rest_counts_the_unsettled_exactly():
    table = rows(("V", "sector", 4.0, 1.0), ("VG", "sector", 4.0, 0.9))
    table.columns["limit_cycle_share"] = np.repeat([1.0, 0.4], 4)
    table.columns["at_rest_share"] = np.repeat([0.0, 0.2], 4)  # their zeros are in the 0.9
    assert effect(table, Count(unsettled=WORST)).effect == pytest.approx(0.6 * 0.9 - 1.0)
    assert {count.unsettled for count in counts(table)} == {DROPPED, WORST}


def test_drawn_controllers_join_the_runs_that_they_were_drawn_from():
    table = rows(("V", "sector", 4.0, [1.0, 2.0, 3.0, 4.0]))
    drawn = StudyTable({**table.columns, "cot_inverse": np.array([0.5, 0.6, 0.7, 0.8])})
    joined = with_sampled(table, drawn)
    assert with_sampled(table, None) is table
    assert len(counts(joined)) == len(counts(table)) * 3 / 2
    of_v = Difference("cot_inverse", V, None)
    assert effect(joined, Count(run=SAMPLED), of_v).effect == 0.8, "the run of highest fitness is 3"
    assert effect(joined, Count(), of_v) == effect(table, Count(), of_v)
