"""The same claims on parts of a study: at each ω_t alone, and after each budget of training."""

from __future__ import annotations

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.studies.paper.claims.architectures import verdicts
from tegotae.studies.paper.claims.verdict import Verdict
from tegotae.studies.paper.table import Table

ALL = "all"
"""The label of all ω_t together."""

PLATEAU = "plateau"
"""The budget of runs that had as much training as they needed."""


def verdicts_by_omega(table: Table) -> dict[str, list[Verdict]]:
    """Claims 2 to 9 on all runs, and on those of each ω_t: a ceiling at one hides nothing there.

    Single networks have no ω_t, and go with each.

    Args:
        table: the study's runs.

    Returns:
        the verdicts by ω_t: "all", and each in rad/s, such as "4" and "8".
    """
    table = table.of_the_paper()
    omega_t = table["omega_t"]
    parts = {f"{omega:g}": omega_t == omega for omega in np.unique(omega_t[np.isfinite(omega_t)])}
    found = {label: _rows(table, at | np.isnan(omega_t)) for label, at in parts.items()}
    return {label: verdicts(rows) for label, rows in {ALL: table, **found}.items()}


def verdicts_by_budget(
    table: Table, final: Table | None = None
) -> dict[float | str, list[Verdict]]:
    """Claims 2 to 9 after each budget of training, so that one sees when a verdict turns.

    A run that has no row at a budget counts with its latest one before it: it had ended by then.
    Rows without a budget, such as of a gain found by search, count at each.

    Args:
        table: runs at several budgets, the column `training_budget` [episodes] saying at which.
        final: the same runs at the end of training.

    Returns:
        the verdicts by budget [episodes], ascending, and at the end of training as "plateau".

    Raises:
        TegotaeError: for a table without that column, or without a budget in it.
    """
    return {budget: verdicts(runs) for budget, runs in _slices(table, final).items()}


def by_budget(table: Table, final: Table | None = None) -> dict[str, Table]:
    """The runs after each budget of training, by a heading, such as "5120 episodes".

    Args:
        table: as for `verdicts_by_budget`.
        final: the same runs at the end of training.

    Raises:
        TegotaeError: for a table without that column, or without a budget in it.
    """
    return {
        budget if isinstance(budget, str) else f"{budget:.0f} episodes": runs
        for budget, runs in _slices(table, final).items()
    }


def _slices(table: Table, final: Table | None) -> dict[float | str, Table]:
    budgets = table.columns.get("training_budget", np.array([]))
    known = np.unique(budgets[~np.isnan(budgets)])
    if len(known) == 0:
        raise TegotaeError("the table has no training_budget; it must say how long each run was")
    found: dict[float | str, Table] = {float(budget): _after(table, budget) for budget in known}
    return found if final is None else found | {PLATEAU: final}


def _after(table: Table, budget: float) -> Table:
    """Every run as it was after a budget [episodes]: its last row up to there."""
    spent = np.nan_to_num(table["training_budget"], nan=0.0)
    last: dict[tuple[str, int], int] = {}
    for row in np.argsort(spent, kind="stable"):
        if spent[row] <= budget:
            last[str(table["model"][row]), int(table["run"][row])] = int(row)
    keep = np.zeros(len(table), bool)
    keep[list(last.values())] = True
    return _rows(table, keep)


def _rows(table: Table, keep: np.ndarray) -> Table:
    return Table({name: column[keep] for name, column in table.columns.items()})
