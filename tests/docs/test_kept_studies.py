"""The kept tables of studies on legs and limits: pages show what they say."""

import fnmatch
import re
from types import SimpleNamespace

import numpy as np
import pandas
import pytest

from pages import DOCS, prose
from prose_numbers import kept_file
from tegotae._support.tables import read_csv
from tegotae.parts.terms import EllipticFoot, Signals
from tegotae.systems.legged import random_phases
from tegotae.training.curves import read_curves

KEPT = DOCS / "_static"
RESEARCH = DOCS.parent / "research"


def column(table: dict, name: str) -> np.ndarray:
    return np.array([float(cell) if cell else np.nan for cell in table[name]])


# Learned legs


def test_a_run_is_selected_by_the_selection_alone(study, monkeypatch, tmp_path):
    evaluation = study("learned_legs.evaluate")
    monkeypatch.setattr(evaluation, "TABLES", tmp_path)  # where there is no other table
    rows = ["cell,run,score", "AR,0,0.1", "AR,1,0.3", "AR,2,0.2", "VG,0,0.9"]
    (tmp_path / "selection.csv").write_text("\n".join(rows) + "\n")
    assert evaluation.selected("AR") == "1"


def test_the_releases_of_selection_test_and_training_are_others(study):
    evaluation = study("learned_legs.evaluate")
    selection, judged = (
        random_phases(4, count, seed)
        for count, seed in (
            (evaluation.SELECTION, evaluation.SELECTION_SEED),
            (evaluation.TEST, evaluation.TEST_SEED),
        )
    )
    assert not np.isin(selection, judged).any()


def test_a_score_is_the_fitness_of_the_training_and_falls_come_last(study):
    evaluation = study("learned_legs.evaluate")
    speed = np.array([[0.2, 0.2], [0.2, 0.2], [0.2, np.nan]])
    cost = evaluation.baseline_cost(np.array(0.2)) * np.array(
        [[1.0, 1.0], [0.5, 0.5], [0.5, np.nan]]
    )
    up = np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    measures = {"speed_m_per_s": speed, "cost_of_transport": cost, "upright": up}
    rows = {name: values.ravel() for name, values in measures.items()}
    evaluated = SimpleNamespace(
        summary=pandas.DataFrame({"run": np.repeat(range(3), 2), "omega": 2.0, **rows})
    )
    standard, cheap, falls = evaluation.scores(evaluated, 0.1)
    assert (standard, cheap) == pytest.approx((0.0, np.log(2.0)))
    assert falls < standard


def test_the_tables_of_learned_legs_follow_from_the_kept_rows(study):
    report = study("learned_legs.report")
    rows, disturbed = report.table("range"), report.table("disturbed")
    folder = RESEARCH / "learned_legs"
    assert (folder / "range.md").read_text() == report.by_family(rows, disturbed)
    assert (folder / "robust.md").read_text() == report.robust(rows, disturbed)


# Go1


def test_the_tables_of_go1_follow_from_the_kept_rows():
    from research.go1 import plan, report

    rows, checks = (pandas.read_csv(plan.FOLDER / f"{name}.csv") for name in ("rows", "checks"))
    tables = {
        "speeds.md": report.laws_table(rows),
        "headings.md": report.headings(rows),
        "checks.md": report.checks_table(rows, checks),
    }
    for name, text in tables.items():
        assert (plan.FOLDER / name).read_text(encoding="utf-8") == text


# The walker's cost


def test_the_table_of_the_walkers_cost_is_the_kept_one(study):
    assert (KEPT / "gaits" / "walker_cost.md").read_text() == study(
        "gaits.walker_cost"
    ).table_text()


def test_two_axes_that_are_netted_cost_less_than_each_by_itself():
    table = read_csv(KEPT / "gaits" / "walker_cost.csv")
    netted, separate, lowest = (
        column(table, name) for name in ("cost_of_transport", "each_axis", "positive_only")
    )
    assert np.all((lowest < netted) & (netted < separate))


@pytest.mark.parametrize("name", ["judge", "map", "simulate", "sweep", "findings"])
def test_every_page_of_walkers_costs_says_what_is_counted(name):
    assert "legs.md#walker-cost" in prose(f"gaits/{name}.md")


# The lightest mode


def test_v_never_rises_without_an_even_part_and_sometimes_with_one(study, monkeypatch):
    lightest = study("gaits.lightest_mode")
    monkeypatch.setattr(lightest, "RANDOM_STATES", 4000)
    assert lightest.rises(0.0) == 0.0
    assert 0.0 < lightest.rises(0.5) < lightest.rises(2.0) < 0.2


# Fig. 3


def test_the_comparison_of_fig_3_follows_from_its_curves(study):
    folder = RESEARCH / "experiments"
    assert (folder / "figure3.md").read_text() == study("experiments.figure3").text(
        read_curves([folder / "figure3.csv"])
    )


LIMIT = 1.296
"""No gait of the default hopper that repeats has more [m/J]."""


@pytest.mark.parametrize(
    ("name", "file", "name_of_column"),
    [
        ("reproduction/algorithms.md", "figure3.csv", "cot_inverse"),
        ("reproduction/algorithms.md", "second_look.csv", "cot_inverse"),
        ("reproduction/parameter_limit.md", "parameter_limit.csv", "cot_inverse_m_per_j"),
    ],
)
def test_numbers_above_the_physical_limit_are_not_shown_without_a_word(name, file, name_of_column):
    largest = np.nanmax(column(read_csv(RESEARCH / "experiments" / file), name_of_column))
    if largest > LIMIT:
        assert f"Values above {LIMIT:g} m/J" in prose(name)
        assert "still settling" in prose(name)


# The optimum that was found, beside a finer search


def test_the_page_says_by_how_much_a_finer_search_beats_the_kept_optimum(study):
    finer = study("experiments.finer_optimum")
    assert (KEPT / "figures" / "optimum.finer.md").read_text() == finer.text()
    ratio = column(read_csv(KEPT / "figures" / "optimum.finer.csv"), "ratio")
    assert f"better by up to {100.0 * (ratio.max() - 1.0):.2f} %" in prose(
        "reproduction/optimum.md"
    )
    assert ratio.max() < 1.0015  # shares of up to 1.001, as the page says


# The study in two bodies


def test_the_table_of_both_readings_follows_from_the_tables_of_their_studies(study):
    two_readings = study("experiments.two_readings")
    summaries = two_readings.estimates_of_readings()
    table = kept_file("study-calibrated/two_readings.md")
    assert table.read_text() == two_readings.text(summaries)
    text = prose("reproduction/two_readings.md")
    settled = [summary["limit_cycle_share", "V", "F"].mean for summary in summaries.values()]
    assert (
        "| settles | {:.0f} % of the episodes | {:.0f} % |".format(
            *(100.0 * share for share in settled)
        )
        in text
    )


# Engines and searches


def test_every_kept_table_of_the_hopper_names_its_engine():
    """A table that no row names, or a row without a table, is a line that was forgotten."""
    patterns = re.findall(r"^\| `([^`]+)`", (DOCS / "reproduction" / "tables.md").read_text(), re.M)
    names, topics = [], ("calibration", "convergence", "experiments", "generalisation")
    roots = {
        KEPT: (".",),
        RESEARCH / "reproduction" / "kept": ("study", "study-calibrated", "multiverse"),
        RESEARCH: (*topics, "oscillators"),
    }
    for root, folders in roots.items():
        paths = [path for name in folders for path in (root / name).glob("*.csv")]
        names += [path.relative_to(root).as_posix() for path in paths]
    assert [n for n in names if not any(fnmatch.fnmatch(n, p) for p in patterns)] == []
    assert [p for p in patterns if not any([*root.glob(p)] for root in roots)] == []


# Lost legs


def test_no_vanilla_walker_goes_on_with_a_margin_below_a_tenth():
    table = read_csv(RESEARCH / "lost_leg" / "bodies.csv")
    margin, walks = column(table, "margin"), column(table, "walks_on")
    assert (walks[margin < 0.1] == 0).all()
    moved = np.asarray(table["body"], str) == "C, quick, mass moved"
    assert walks[moved].tolist() == [0, 0, 64, 0]  # LF, RF, LH, RH
    quick = np.asarray(table["body"], str) == "hexapod, quick"
    assert f"{walks[quick].min():.0f} to {walks[quick].max():.0f} of 64" in prose(
        "studies/lost_leg.md"
    )


def test_laws_that_react_go_on_without_any_leg_and_the_page_says_in_how_many_starts():
    table = read_csv(RESEARCH / "lost_leg" / "reacting.csv")
    body, run = (np.asarray(table[name], str) for name in ("body", "run"))
    walks = column(table, "walks_on")
    assert (walks[body == "no reaction"] == 0).all()
    text = prose("studies/lost_leg.md")
    learned = walks[body == "feels-tilt"]
    assert f"in {learned.min():.0f} to {learned.max():.0f} of 64 starts" in text
    assert walks[(body == "feels-tilt") & (run == "2")].tolist() == [64, 63, 64, 64]
    by_hand = [walks[(body == "shift-by-hand") & (run == str(k))].min() for k in range(6)]
    assert sum(count == 64 for count in by_hand) == 5


def test_no_law_shifts_a_foot_further_than_is_allowed_and_sides_are_mirror_images(study):
    laws = study("lost_leg.laws")
    law = laws.Law("a", "a law", EllipticFoot(), ("pitch", "roll"), 3, "place")
    x = np.random.default_rng(0).normal(size=(50, law.size)) * 5.0
    legs = law.weights(x, 1.9).reshape(50, 4, law.unit)  # LF, RF, LH, RH
    neurons = legs[..., 1:].reshape(50, 4, 2, 3, 4)
    largest = np.abs(neurons[..., -1]).sum(axis=-1)
    assert largest[..., 0].max() <= laws.SHIFT_M * (1.0 + 1e-9)
    assert largest[..., 1].max() <= laws.LIFT_M * (1.0 + 1e-9)
    left, right = neurons[:, ::2], neurons[:, 1::2]
    assert np.array_equal(right, left * [1.0, -1.0, 1.0, 1.0])


# The limit for legs


@pytest.mark.parametrize("feet", ["free", "ellipse"])
def test_a_gait_is_the_same_in_a_larger_space(study, feet):
    gaits = study("legs_limit.gaits")
    small, large = gaits.Space(feet, 3), gaits.Space("free", 5)
    x = small.random(np.random.default_rng(1)) + 0.3
    feet = [
        feet_of(space, coordinates)
        for space, coordinates in ((small, x), (large, large.from_space(small, x)))
    ]
    assert np.ptp(feet[0]) > 0.1
    assert np.abs(feet[0] - feet[1]).max() < 1e-4


def feet_of(space, x):
    """Places of the feet of a gait in open loop over a while, [legs, 2, times]."""
    weights, scenario = space.decoded(x[None], np.array([0.5]))
    time, n = np.linspace(0.0, 8.0, 40), space.foot.n_weights
    phase = scenario.phase_rad + scenario.omega * time
    pairs = zip(weights[0].reshape(4, n), phase, strict=True)
    return np.array(
        [
            space.foot(leg_weights, Signals({"cos_phase": np.cos(a), "sin_phase": np.sin(a)}))
            for leg_weights, a in pairs
        ]
    )
