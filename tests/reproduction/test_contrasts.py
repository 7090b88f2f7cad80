"""Contrasts: all that is compared is chosen on one half of the releases and judged on the other."""

import itertools

import numpy as np
import pandas as pd
import pytest

from research.reproduction.learning.contrasts import (
    best_of,
    comparisons,
    contrast_rows,
    contrast_table,
)
from research.reproduction.learning.works import WORKS, gains, works_table

OMEGAS = (4.0, 8.0)


def runs_of(architecture, drive, merits):
    """Rows at both frequencies: (chosen, judged) of each run, and half of it where locked."""
    return [
        {
            "senses": "F",
            "architecture": architecture,
            "drive": drive,
            "omega_t": omega,
            "run": run,
            "merit_chosen": chosen,
            "merit_judged": judged,
            "locked_chosen": 0.5 * chosen,
            "locked_judged": 0.5 * judged,
        }
        for omega in OMEGAS
        for run, (chosen, judged) in enumerate(merits)
    ]


@pytest.fixture
def runs():
    return pd.DataFrame(
        [
            *runs_of("V", "φ", [(0.3, 0.4)]),
            *runs_of("V", "f", [(0.2, 0.9)]),  # better where it is judged, which chooses nothing
            *runs_of("AR", "φ", [(0.6, 0.5), (0.1, 0.1)]),
            *runs_of("ART", "f", [(0.4, 0.8), (0.2, 1.0)]),
            *runs_of("law", "latch", [(0.0, 1.0), (0.7, 0.6)]),
            *runs_of("law", "clock", [(0.3, 0.3), (0.1, 0.2)]),
        ]
    )


def test_the_base_is_the_best_v_on_the_first_half_of_the_releases(runs):
    clock = comparisons(runs)["clock − best V"]
    np.testing.assert_allclose(clock.differences, [[-0.1, -0.1]])
    assert clock.omegas == OMEGAS


def test_the_mean_of_runs_and_the_chosen_run_are_both_judged_on_the_second_half(runs):
    by_name = comparisons(runs)
    mean, chosen = (by_name[f"learned, {x} − best V"] for x in ("mean of runs", "chosen run"))
    np.testing.assert_allclose(mean.differences, [[-0.1, -0.1], [0.5, 0.5]])
    np.testing.assert_allclose(chosen.differences, [[0.1, 0.1], [0.4, 0.4]])


def test_a_short_law_is_chosen_among_all_laws_and_runs(runs):
    by_name = comparisons(runs)
    np.testing.assert_allclose(by_name["best short law − best V"].differences, [[0.2, 0.2]])
    over_law = by_name["learned, chosen run − best short law"]
    np.testing.assert_allclose(over_law.differences, [[-0.1, -0.1], [0.2, 0.2]])


def test_the_best_design_is_chosen_by_the_mean_of_its_runs(runs):
    design = comparisons(runs)["learned, best design, mean of runs − best V"]
    np.testing.assert_allclose(design.differences, [[-0.1, -0.1]])  # AR, 0.35 where it is chosen


def test_the_best_of_so_many_runs_is_the_mean_over_all_draws(runs):
    laws = runs[runs.architecture == "law"]
    at_four = laws[laws.omega_t == 4.0]
    for number in (1, 2, 3, 4):
        draws = [
            at_four.loc[list(draw)].nlargest(1, "merit_chosen").merit_judged.item()
            for draw in itertools.combinations(at_four.index, number)
        ]
        assert best_of(laws, "merit", number)[4.0].item() == pytest.approx(np.mean(draws))


def test_both_sides_of_an_equal_choice_have_as_many_runs(runs):
    equal = comparisons(runs)["learned − short laws, best of 15 runs"]
    np.testing.assert_allclose(equal.differences, [[-0.1, -0.1]])  # of all: 0.5 against 0.6


def test_locked_episodes_are_compared_by_their_own_merits(runs):
    half, whole = comparisons(runs, "locked"), comparisons(runs)
    for name, comparison in whole.items():
        np.testing.assert_allclose(half[name].differences, 0.5 * comparison.differences)


def test_the_table_has_a_row_a_body_comparison_and_kind_of_episodes(runs):
    rows = contrast_rows({"study": runs, "other": runs})
    assert len(rows) == 2 * 2 * len(comparisons(runs))
    row = rows[(rows.comparison == "learned, mean of runs − best V") & (rows.episodes == "all")]
    assert row["all"].tolist() == pytest.approx([0.2, 0.2])
    assert (row.low < 0.2).all()
    assert (row.high > 0.2).all()
    table = contrast_table(rows)
    assert "| study | all | clock − best V | -0.100 [" in table
    assert "| study, all episodes | 4 | 8 |" in table
    assert "| clock − best V | -0.10 | -0.10 |" in table


def test_searched_laws_are_chosen_like_runs_and_stand_beside_v_and_learned_feedback(runs):
    searched = pd.DataFrame(
        [
            *runs_of("law by DE", "load", [(0.8, 0.7)]),
            *runs_of("law by DE", "clock", [(0.2, 0.9)]),  # not chosen: worse on the first half
        ]
    )
    rows = comparisons(pd.concat([runs, searched]))
    np.testing.assert_allclose(rows["best law by DE − best V"].differences, [[0.3, 0.3]])
    mean = rows["learned, mean of runs − best law by DE"].differences
    np.testing.assert_allclose(mean, [[-0.4, -0.4], [0.2, 0.2]])
    assert not any("CMA-ES" in name for name in rows), "none was given"


def test_a_gain_is_relative_to_the_larger_and_unfinished_bodies_have_none(runs):
    """V has 0.4 where it is judged; AR and ART have 0.3 and 0.9 on average."""
    rows = runs[runs.architecture.isin(["V", "AR", "ART"])].assign(
        model=lambda x: x.architecture + "-" + x.drive + x.omega_t.astype(str) + x.run.astype(str)
    )
    rows["model"] = "V-both-" + rows.model  # any that comes first
    bodies = [rows.assign(body=body, work=work) for body in range(3) for work in WORKS]
    by_work = gains(pd.concat([*bodies[:-1], bodies[-1].iloc[:-1]]))
    assert by_work.loc[0].tolist() == pytest.approx([0.2 / 0.6] * 3)
    assert np.isnan(by_work.loc[2, "net"])
    table = works_table(by_work)
    assert "| absolute | 3 | +0.33 [+0.33, +0.33] | – | 3 | 0 |" in table
    assert "| net | 2 |" in table
