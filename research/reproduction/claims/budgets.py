"""A study's runs after each budget of training, so that one sees when a verdict turns."""

from __future__ import annotations

import numpy as np

from research.reproduction.table import StudyTable
from tegotae._support.errors import TegotaeError

PLATEAU = "plateau"
"""The budget of runs that had as much training as they needed."""


def by_budget(table: StudyTable, final: StudyTable | None = None) -> dict[str, StudyTable]:
    """Return the runs after each budget of training, ascending, by a heading, such as "5120
    episodes".

    A run that has no row at a budget counts with its latest one before it: it had ended by then.
    Rows without a budget, such as of a gain found by search, count at each.

    Args:
        table: runs at several budgets, the column `training_budget` [episodes] saying at which.
        final: the same runs at the end of training, as "plateau".

    Raises:
        TegotaeError: for a table without that column, or without a budget in it.
    """
    budgets = table.columns.get("training_budget", np.array([]))
    distinct = np.unique(budgets[~np.isnan(budgets)])
    if len(distinct) == 0:
        raise TegotaeError("the table has no training_budget; it must say how long each run was")
    tables = {f"{budget:.0f} episodes": _with_budget(table, float(budget)) for budget in distinct}
    return tables if final is None else tables | {PLATEAU: final}


def _with_budget(table: StudyTable, budget: float) -> StudyTable:
    """Return every run as it was after a budget [episodes]: its last row up to there."""
    spent = np.nan_to_num(table["training_budget"], nan=0.0)
    last: dict[tuple[str, int], int] = {}
    for row in np.argsort(spent, kind="stable"):
        if spent[row] <= budget:
            last[str(table["model"][row]), int(table["run"][row])] = int(row)
    keep = np.zeros(len(table), bool)
    keep[list(last.values())] = True
    return _rows(table, keep)


def _rows(table: StudyTable, keep: np.ndarray) -> StudyTable:
    return StudyTable({name: column[keep] for name, column in table.columns.items()})
