"""Runs after each budget of training, and how they ended."""

from typing import Any

import numpy as np

from research.reproduction.claims.budgets import by_budget
from research.reproduction.endings import endings, endings_by_architecture
from research.reproduction.report.markdown import endings_table
from research.reproduction.table import StudyTable
from study_tables import results

ART_BETTER = {"ART": {"cot_inverse": 0.5}}


def where(table: StudyTable, keep: np.ndarray) -> StudyTable:
    return StudyTable({name: column[keep] for name, column in table.columns.items()})


def stacked(*tables: StudyTable) -> StudyTable:
    return StudyTable({n: np.concatenate([t[n] for t in tables]) for n in tables[0].columns})


def at_budget_of(table: StudyTable, episodes: float) -> StudyTable:
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
    table = stacked(at_budget_of(results({}), 1280.0), at_budget_of(results(ART_BETTER), 5120.0))
    effects = gains(table)
    assert list(effects) == ["1280 episodes", "5120 episodes"]
    assert abs(effects["1280 episodes"]) < 0.1
    assert effects["5120 episodes"] > 0.4


def test_the_end_of_training_stands_last():
    effects = gains(at_budget_of(results({}), 1280.0), results(ART_BETTER))
    assert list(effects) == ["1280 episodes", "plateau"]
    assert effects["plateau"] > 0.4


def test_a_run_that_had_ended_counts_as_it_ended():
    early = at_budget_of(results({}), 1280.0)
    late = at_budget_of(results(ART_BETTER), 5120.0)
    goes_on = late["architecture"] == "ART"
    at_budget = by_budget(stacked(early, where(late, goes_on)))["5120 episodes"]
    assert len(at_budget) == len(early)
    assert np.mean(at_budget.where(architecture="ART")["cot_inverse"]) > 1.4
    still = at_budget.where(architecture="AR")["cot_inverse"]
    np.testing.assert_array_equal(still, early.where(architecture="AR")["cot_inverse"])


def test_a_run_without_a_budget_counts_at_each():
    table = results({})
    searched = table["architecture"] == "V"
    v = at_budget_of(where(table, searched), np.nan)
    trained = where(table, ~searched)
    tables = by_budget(stacked(v, at_budget_of(trained, 1280.0), at_budget_of(trained, 2560.0)))
    assert [len(rows) for rows in tables.values()] == [len(table)] * 2


# How training ended.


def ended(fitness: Any, reason: Any, share: Any = 1.0) -> StudyTable:
    """The three runs of one model."""
    table = results({}).where(model="ART-rF-tphif-w8")
    columns = {"best_fitness": fitness, "ended": reason, "limit_cycle_share": share}
    return StudyTable(
        {**table.columns, **{n: np.broadcast_to(np.array(v), (3,)) for n, v in columns.items()}}
    )


def test_a_plateau_below_nine_tenths_of_the_best_run_is_a_local_optimum():
    counted = endings(ended([1.0, 0.91, 0.89], "plateau"))
    assert (counted.runs, counted.local_optimum, counted.at_cap, counted.never_hop) == (3, 1, 0, 0)


def test_a_run_at_the_cap_is_no_local_optimum_however_low():
    counted = endings(ended([1.0, 0.1, 0.1], ["plateau", "cap", "plateau"]))
    assert (counted.local_optimum, counted.at_cap) == (1, 1)


def test_a_run_that_never_hops_is_counted_as_that_alone():
    counted = endings(ended([1.0, -65.0, 0.2], "plateau", [1.0, 0.0, 0.0]))
    assert (counted.never_hop, counted.local_optimum, counted.without_cycle) == (1, 1, 2)


def test_where_nothing_was_found_nothing_was_missed():
    assert endings(ended([-0.1, -1.0, -65.0], "plateau")).local_optimum == 0


def test_a_table_that_does_not_say_how_training_ended_leaves_that_open():
    counted = endings(results({}))
    assert counted.local_optimum is None
    assert counted.at_cap is None
    assert "| all | 654 | 0 | – | – | 0 |" in endings_table({"all": counted})


def test_architectures_are_counted_apart_and_together():
    counted = endings_by_architecture(results({}))
    assert (
        sum(entry.runs for name, entry in counted.items() if name != "all") == counted["all"].runs
    )
