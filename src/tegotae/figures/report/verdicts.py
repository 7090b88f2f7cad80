"""What a study's tables say of the claims, as files of Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from tegotae.figures.report.markdown import claims_table, endings_table, verdicts_table
from tegotae.studies.paper.claims import (
    ALL,
    Verdict,
    all_verdicts,
    verdicts,
    verdicts_by_budget,
    verdicts_by_omega,
)
from tegotae.studies.paper.endings import endings_by_architecture
from tegotae.studies.paper.table import Table


def verdict_texts(
    table: Table,
    experiments: Path | None = None,
    budgets: Table | None = None,
    beside: Mapping[str, Table] | None = None,
) -> dict[str, str]:
    """The tables by the name of their file.

    - `claims.md`: every claim, with the verdicts at each ω_t and those of other studies beside;
    - `claims-w4.md`, ...: the same at one ω_t, with its effects;
    - `claims-by-budget.md`: the verdicts after each budget of training;
    - `endings.md`: how the runs of each architecture ended.

    Args:
        table: the study's runs.
        experiments: folder of the experiments on claims 1, 10 and 11.
        budgets: the same runs after several budgets of training.
        beside: other studies' runs, by their names.

    Raises:
        TegotaeError: if the folder of the experiments or one of its tables cannot be read, or
            `budgets` does not say how long each run was.
    """
    by_omega = verdicts_by_omega(table)
    del by_omega[ALL]
    columns = {f"ω_t = {omega}": found for omega, found in by_omega.items()}
    columns |= {name: verdicts(runs) for name, runs in (beside or {}).items()}
    texts = {"claims.md": claims_table(all_verdicts(table, experiments), columns)}
    texts |= {f"claims-w{omega}.md": claims_table(found) for omega, found in by_omega.items()}
    if budgets is not None:
        texts["claims-by-budget.md"] = verdicts_table(labelled(verdicts_by_budget(budgets, table)))
    texts["endings.md"] = endings_table(endings_by_architecture(table))
    return texts


def labelled(by_budget: Mapping[float | str, list[Verdict]]) -> dict[str, list[Verdict]]:
    """The same by a heading, such as "5120 episodes", or the word that a budget is."""
    return {
        budget if isinstance(budget, str) else f"{budget:.0f} episodes": found
        for budget, found in by_budget.items()
    }
