"""Each claim is judged by its effects' intervals: made-up results with known verdicts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from study_tables import results
from tegotae._support.errors import TegotaeError
from tegotae.figures.data import write_tables
from tegotae.figures.learning_curves import algorithms_tables
from tegotae.studies.paper.claims import (
    EXPERIMENTS,
    FAILS,
    HOLDS,
    INFORMATION,
    MODELS,
    NOT_MEASURED,
    UNDECIDED,
    claim_1,
    claim_11,
    correlation,
    experiment_verdicts,
    verdicts,
)
from tegotae.studies.paper.table import Table
from tegotae.training.curves import LearningCurve


def verdict(table: Table, number: int) -> str:
    return next(v.verdict for v in verdicts(table) if v.number == number)


def test_a_clear_effect_in_the_claimed_direction_holds() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    assert verdict(table, 2) == HOLDS


def test_a_clear_effect_against_the_claim_fails() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": -0.5, "t1_s": 1.0}})
    assert verdict(table, 2) == FAILS


KNOWN = [
    # AR is compared with V in efficiency and with VG in the rest.
    (4, {"AR": {"cot_inverse": 0.5, "t0_s": -0.5, "t1_s": -0.5, "delta_w": -0.5}}, HOLDS),
    (4, {"AR": {"cot_inverse": 0.5, "t0_s": 0.5, "t1_s": -0.5, "delta_w": -0.5}}, FAILS),
    (5, {"ART": {"cot_inverse": 0.5}}, HOLDS),
    (5, {"AR": {"cot_inverse": 0.5}}, FAILS),
    (6, {"ARG": {"cot_inverse": -0.5}, "ARGT": {"cot_inverse": -0.5}}, HOLDS),
    (6, {"ARG": {"cot_inverse": -0.5}, "ART": {"cot_inverse": -0.5}}, FAILS),
    (
        8,
        {
            f"{a}/Fv": {"cpgu": -0.3, "cot_inverse": 0.3, "t1_s": 0.3}
            for a in ("AR", "ART", "ARG", "ARGT")
        },
        HOLDS,
    ),
    (8, {f"{a}/Fv": {"cot_inverse": -0.3} for a in ("AR", "ART", "ARG", "ARGT")}, FAILS),
    # Efficient models that are slow, and dependent ones that are quick.
    (
        9,
        {
            "VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0},
            "AR": {"cpgu": 0.5, "t1_s": -0.5},
        },
        HOLDS,
    ),
    (9, {"VG": {"cot_inverse": 1.0, "t0_s": -1.0, "t1_s": -1.0}}, FAILS),
]


@pytest.mark.parametrize(("number", "effects", "expected"), KNOWN)
def test_made_up_results_have_the_verdicts_that_they_were_made_for(number, effects, expected):
    assert verdict(results(effects), number) == expected


def test_efficiencies_of_frequencies_that_differ_do_not_mix_in_a_correlation() -> None:
    """Within each ω_t no correlation; over all, one that the frequencies alone make."""
    table = results({}, noise=0.05)
    for metric in ("cot_inverse", "t0_s"):
        table[metric][table["omega_t"] == 4.0] += 1.0
    overall, within = next(v for v in verdicts(table) if v.number == 9).parts[:2]
    assert overall.effect.low > 0.8
    assert within.effect.low < 0.2
    assert within.verdict == INFORMATION


def test_no_effect_is_undecided_or_fails_but_never_holds() -> None:
    table = results({}, noise=0.5)
    assert all(v.verdict != HOLDS for v in verdicts(table) if v.number in (4, 5, 6, 8))


def test_nearness_is_an_equivalence_and_not_a_missing_difference() -> None:
    smoother = {"VT": {"smoothness": -0.5}}
    assert verdict(results(smoother), 3) == HOLDS
    assert verdict(results({"VT": {"smoothness": -0.5, "cot_inverse": 0.5}}), 3) == FAILS


def test_the_single_network_fails_without_velocity_and_is_on_par_with_it() -> None:
    table = results({"T/F": {"limit_cycle_share": -1.0}, "T/Fv": {"t0_s": 1.0}})
    assert verdict(table, 7) == HOLDS


def test_runs_without_a_limit_cycle_are_counted_and_left_out() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    lost = (table["architecture"] == "VG") & (table["run"] == 0)
    table["t1_s"][lost] = np.nan
    claim = next(v for v in verdicts(table) if v.number == 2)
    counts = {part.what: part.effect for part in claim.parts}
    assert counts["T1, VG - V [s]"].undefined == (lost & (table["observation"] == "F")).sum()
    assert claim.verdict == HOLDS


def test_without_results_no_claim_is_measured() -> None:
    empty = Table({name: column[:0] for name, column in results({}).columns.items()})
    assert {v.verdict for v in verdicts(empty)} == {NOT_MEASURED}


def test_a_claim_that_compares_with_what_was_not_run_is_not_measured() -> None:
    """Three models: what is said of others is left to who measures them."""
    three = results({}).where(model=("V-sector-w8", "ART-rF-tphif-w8", "T-Fv"))
    assert {v.verdict for v in verdicts(three)} == {NOT_MEASURED}
    comparison = next(v for v in verdicts(three) if v.number == 5).parts[0]
    assert (comparison.verdict, comparison.n) == (NOT_MEASURED, 0)


def test_a_claim_of_which_a_part_was_not_measured_is_undecided_or_fails() -> None:
    parts = {"ARG": {"cot_inverse": -0.5}, "ART": {"cot_inverse": 0.5}}
    table = results(parts)
    half = table.where(architecture=("V", "ARG"))
    claim = next(v for v in verdicts(half) if v.number == 6)
    assert [part.verdict for part in claim.parts] == [HOLDS, NOT_MEASURED]
    assert claim.verdict == UNDECIDED
    against = results({"ARG": {"cot_inverse": 0.5}}).where(architecture=("V", "ARG"))
    assert verdict(against, 6) == FAILS


def test_runs_that_never_settle_are_data_and_leave_a_claim_undecided() -> None:
    table = results({})
    table["cot_inverse"][:] = np.nan
    table["limit_cycle_share"][:] = 0.0
    assert verdict(table, 5) == UNDECIDED


@pytest.mark.parametrize("models", [3, MODELS - 1, MODELS])
def test_a_correlation_needs_enough_models(models: int) -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    some = table.where(model=tuple(dict.fromkeys(table["model"].tolist()))[:models])
    found = correlation(some.per_model(), "cot_inverse", "t0_s")
    assert np.isfinite(found.mean) == (models >= MODELS)
    claim = next(v for v in verdicts(some) if v.number == 9)
    assert (claim.verdict == NOT_MEASURED) == (models < MODELS)
    assert "at least 10 models" in claim.note


def test_the_correlation_of_a_line_is_one_and_its_interval_knows_its_sample() -> None:
    x = np.arange(20.0)
    line = Table({"a": x, "b": 2.0 * x + 1.0})
    assert correlation(line, "a", "b").mean == pytest.approx(1.0)
    with_holes = Table({"a": x, "b": np.where(x < 2, np.nan, x)})
    found = correlation(with_holes, "a", "b")
    assert (found.count, found.undefined) == (18, 2)


def test_an_architecture_that_settles_at_one_frequency_alone_is_judged_there() -> None:
    table = results({"ART": {"cot_inverse": 0.5}})
    table["cot_inverse"][table["omega_t"] == 4.0] += 5.0
    at_4 = (table["architecture"] == "ART") & (table["omega_t"] == 4.0)
    table["cot_inverse"][at_4] = np.nan
    part = next(v for v in verdicts(table) if v.number == 5).parts[0]
    assert part.verdict == HOLDS
    assert 0.4 < part.effect.mean < 0.6


def test_the_runs_behind_a_part_are_counted_with_those_without_a_limit_cycle() -> None:
    table = results({})
    lost = (table["architecture"] == "AR") & (table["observation"] == "F") & (table["run"] == 0)
    table["limit_cycle_share"][lost] = 0.0
    table["cot_inverse"][lost] = np.nan
    part = next(v for v in verdicts(table) if v.number == 4).parts[0]
    on_f = table["observation"] == "F"
    assert part.n == (on_f & np.isin(table["architecture"], ("AR", "V"))).sum()
    assert part.without_cycle == part.effect.undefined == lost.sum() > 0


# Claims with experiments of their own.


def curves(algorithm: str, late: float, *, points: int = 100, model: str = "m", noise: float = 0.0):
    """Three runs that rise to `late` along a line; an episode is 10 s."""
    random = np.random.default_rng(0)
    episode = np.arange(points, dtype=float)
    rise = np.linspace(0.0, late, points)
    return [
        LearningCurve(algorithm, model, seed, episode, 10.0 * episode, rise + noise * shift)
        for seed, shift in enumerate(random.normal(size=3))
    ]


def test_pgpe_beats_the_others_if_it_does_on_every_policy_and_scale() -> None:
    others = [*curves("sac", 0.5), *curves("ppo", 0.2)]
    assert claim_1([*curves("pgpe", 1.0), *others]).verdict == HOLDS
    assert claim_1([*curves("pgpe", 0.1), *others]).verdict == FAILS
    assert claim_1([*curves("pgpe", 0.5, noise=1.0), *curves("sac", 0.5, noise=2.0)]).verdict == (
        UNDECIDED
    )


def test_a_longer_training_is_an_advantage_at_its_end_and_none_at_equal_time() -> None:
    # The agent ends higher, but is below where the evolution ends.
    verdict = claim_1([*curves("pgpe", 1.0), *curves("sac", 2.0, points=1000)])
    at_the_end, at_equal_time = verdict.parts
    assert (at_the_end.verdict, at_equal_time.verdict) == (FAILS, HOLDS)


def test_pgpe_alone_beats_nobody() -> None:
    assert claim_1(curves("pgpe", 1.0)).verdict == NOT_MEASURED


def leave_sizes(folder: Path, fitness: dict[int, float]) -> None:
    """`parameter_limit.csv`: three trainings of each size, one of which began with a failure."""
    random = np.random.default_rng(0)
    rows = ["way,parameters,seed,untrained_fitness,fitness"]
    for size, value in fitness.items():
        for seed, start in enumerate((-1e6, -2.0, -2.1)):
            rows.append(f"scaled,{size},{seed},{start},{value + 0.01 * random.normal()}")
    (folder / "parameter_limit.csv").write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize(
    ("fitness", "expected"),
    [
        ({96: 1.0, 256: 0.9, 4096: 0.8}, FAILS),
        ({96: 1.0, 256: 0.9, 4096: -1.9}, FAILS),
        ({96: 1.0, 256: -1.8, 4096: -1e6}, HOLDS),
        ({96: 1.0, 128: 1.0}, NOT_MEASURED),
    ],
)
def test_many_parameters_cannot_be_trained_if_they_stay_near_random_weights(
    tmp_path, fitness, expected
) -> None:
    leave_sizes(tmp_path, fitness)
    assert experiment_verdicts(tmp_path)[1].verdict == expected


def test_a_gain_that_grows_along_a_line_for_the_sector_alone() -> None:
    random = np.random.default_rng(0)
    omega = np.linspace(2.0, 10.0, 60)
    line, cloud = 1.3 * omega + 0.1 * random.normal(size=60), random.uniform(0.0, 10.0, 60)
    assert claim_11({"sector": (omega, line), "reflex": (omega, cloud)}).verdict == HOLDS
    assert claim_11({"sector": (omega, -line), "reflex": (omega, cloud)}).verdict == FAILS
    assert claim_11({"sector": (omega, line), "reflex": (omega, line)}).verdict == FAILS
    few = {"sector": (omega[:2], line[:2]), "reflex": (omega, cloud)}
    assert claim_11(few).verdict == UNDECIDED


def test_a_best_gain_that_the_edge_of_the_map_censors_is_counted_and_not_fitted(tmp_path) -> None:
    omega = np.linspace(2.0, 10.0, 60)
    best = np.minimum(1.3 * omega, 6.0)
    censored = best == 6.0
    ridge = {
        "actuation": np.repeat(["sector", "reflex"], 60),
        "omega_rad_per_s": np.tile(omega, 2),
        "best_sigma_rad_per_s_n": np.concatenate([best, np.sin(5.0 * omega)]),
        "censored": np.concatenate([censored, np.zeros(60, bool)]).astype(int),
    }
    write_tables(tmp_path / "gain_map.png", {"ridge": ridge})
    verdict = experiment_verdicts(tmp_path)[2]
    slope, line, _ = verdict.parts
    assert verdict.verdict == HOLDS
    assert slope.effect.mean == pytest.approx(1.3)
    assert (line.effect.count, line.effect.undefined) == (60 - censored.sum(), censored.sum())


def test_experiments_are_read_from_the_tables_that_their_commands_write(tmp_path) -> None:
    runs = [*curves("pgpe", 1.0), *curves("sac", 0.5)]
    write_tables(tmp_path / "figure3.png", algorithms_tables(runs))
    omega = np.linspace(2.0, 10.0, 9)
    ridge = {
        "actuation": np.repeat(["sector", "reflex"], 9),
        "omega_rad_per_s": np.tile(omega, 2),
        "best_sigma_rad_per_s_n": np.concatenate([omega, np.sin(5.0 * omega)]),
        "censored": np.zeros(18, int),
    }
    write_tables(tmp_path / "gain_map.png", {"ridge": ridge})
    assert [v.verdict for v in experiment_verdicts(tmp_path)] == [HOLDS, NOT_MEASURED, HOLDS]


def test_an_experiment_that_is_missing_says_what_measures_it(tmp_path) -> None:
    for verdict in (*experiment_verdicts(), *experiment_verdicts(tmp_path)):
        assert verdict.verdict == NOT_MEASURED
        assert "to measure: " in verdict.note
    with pytest.raises(TegotaeError, match="there is no folder"):
        experiment_verdicts(tmp_path / "nowhere")


@pytest.mark.parametrize("table", [e.table for e in EXPERIMENTS])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n", "\x00\x01", "actuation,way\nsector\n"])
def test_a_table_that_is_none_is_named_in_one_line(tmp_path, table, content) -> None:
    (tmp_path / table).write_text(content)
    with pytest.raises(TegotaeError, match=table) as error:
        experiment_verdicts(tmp_path)
    assert len(str(error.value).splitlines()) == 1
