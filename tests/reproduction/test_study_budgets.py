"""Runs after each budget of training, and how they ended."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reproduction.claims.budgets import by_budget
from reproduction.endings import endings, endings_by_architecture
from reproduction.report.markdown import endings_table
from reproduction.table import StudyTable
from study_tables import results
from tegotae._support.errors import TegotaeError

ART_BETTER = {"ART": {"cot_inverse": 0.5}}


def where(table: StudyTable, keep: np.ndarray) -> StudyTable:
    return StudyTable({name: column[keep] for name, column in table.columns.items()})


def stacked(*tables: StudyTable) -> StudyTable:
    return StudyTable({n: np.concatenate([t[n] for t in tables]) for n in tables[0].columns})


def after(table: StudyTable, episodes: float) -> StudyTable:
    return StudyTable({**table.columns, "training_budget": np.full(len(table), episodes)})


def gains(table: StudyTable, final: StudyTable | None = None) -> dict[str, float]:
    """ART's CoT⁻¹ over AR's [m/J], after each budget."""
    return {
        name: float(
            np.mean(runs.where(architecture="ART")["cot_inverse"])
            - np.mean(runs.where(architecture="AR")["cot_inverse"])
        )
        for name, runs in by_budget(table, final).items()
    }


# By the budget of training.


def test_one_sees_when_a_verdict_turns():
    table = stacked(after(results({}), 1280.0), after(results(ART_BETTER), 5120.0))
    found = gains(table)
    assert list(found) == ["1280 episodes", "5120 episodes"]
    assert abs(found["1280 episodes"]) < 0.1
    assert found["5120 episodes"] > 0.4


def test_the_end_of_training_stands_last():
    found = gains(after(results({}), 1280.0), results(ART_BETTER))
    assert list(found) == ["1280 episodes", "plateau"]
    assert found["plateau"] > 0.4


def test_a_run_that_had_ended_counts_as_it_ended():
    early = after(results({}), 1280.0)
    late = after(results(ART_BETTER), 5120.0)
    goes_on = late["architecture"] == "ART"
    found = by_budget(stacked(early, where(late, goes_on)))["5120 episodes"]
    assert len(found) == len(early)
    assert np.mean(found.where(architecture="ART")["cot_inverse"]) > 1.4
    still = found.where(architecture="AR")["cot_inverse"]
    np.testing.assert_array_equal(still, early.where(architecture="AR")["cot_inverse"])


def test_a_run_without_a_budget_counts_at_each():
    table = results({})
    searched = table["architecture"] == "V"
    v = after(where(table, searched), np.nan)
    trained = where(table, ~searched)
    found = by_budget(stacked(v, after(trained, 1280.0), after(trained, 2560.0)))
    assert [len(each) for each in found.values()] == [len(table)] * 2


@pytest.mark.parametrize("budget", [None, np.nan])
def test_runs_of_unknown_budget_are_refused(budget):
    table = results({}) if budget is None else after(results({}), budget)
    with pytest.raises(TegotaeError, match="has no training_budget"):
        by_budget(table)


# How training ended.


def ended(fitness: Any, why: Any, share: Any = 1.0) -> StudyTable:
    """The three runs of one model."""
    table = results({}).where(model="ART-rF-tphif-w8")
    columns = {"best_fitness": fitness, "ended": why, "limit_cycle_share": share}
    return StudyTable(
        {**table.columns, **{n: np.broadcast_to(np.array(v), (3,)) for n, v in columns.items()}}
    )


def test_a_plateau_below_nine_tenths_of_the_best_run_is_a_local_optimum():
    found = endings(ended([1.0, 0.91, 0.89], "plateau"))
    assert (found.runs, found.local_optimum, found.at_cap, found.never_hop) == (3, 1, 0, 0)


def test_a_run_at_the_cap_is_no_local_optimum_however_low():
    found = endings(ended([1.0, 0.1, 0.1], ["plateau", "cap", "plateau"]))
    assert (found.local_optimum, found.at_cap) == (1, 1)


def test_a_run_that_never_hops_is_counted_as_that_alone():
    found = endings(ended([1.0, -65.0, 0.2], "plateau", [1.0, 0.0, 0.0]))
    assert (found.never_hop, found.local_optimum, found.without_cycle) == (1, 1, 2)


def test_where_nothing_was_found_nothing_was_missed():
    assert endings(ended([-0.1, -1.0, -65.0], "plateau")).local_optimum == 0


def test_a_table_that_does_not_say_how_training_ended_leaves_that_open():
    found = endings(results({}))
    assert found.local_optimum is None
    assert found.at_cap is None
    assert "| all | 654 | 0 | – | – | 0 |" in endings_table({"all": found})


def test_architectures_are_counted_apart_and_together():
    found = endings_by_architecture(results({}))
    assert sum(each.runs for name, each in found.items() if name != "all") == found["all"].runs
