"""Endings of trainings: at the plateau or at the cap, in a local optimum, without ever hopping."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from research.reproduction.table import StudyTable

LOCAL_OPTIMUM = 0.9
"""A run stays in a local optimum if it ends at its plateau with less than this share of the fitness
of its model's best run."""

NO_HOP = 1e-3
"""The largest fitness without hopping: CoT⁻¹ is zero then, ΔΩ at most zero, and the tie-break of
the fitness below this."""


@dataclass(frozen=True)
class RunEndings:
    """Endings of some runs. None where the table lacks the endings.

    Args:
        runs: how many there are.
        never_hop: runs whose best fitness is that of a body that does not hop, at most
            `NO_HOP`, and which have no limit cycle in any episode of the evaluation.
        local_optimum: other runs that end at their plateau with less than `LOCAL_OPTIMUM` of the
            fitness of their model's best run.
        at_cap: runs that were stopped by the cap, before their plateau.
        without_cycle: runs without a limit cycle in any episode, those that never hop among them.
    """

    runs: int
    never_hop: int
    local_optimum: int | None
    at_cap: int | None
    without_cycle: int


def endings(table: StudyTable) -> RunEndings:
    """Count the endings of a table's runs.

    Args:
        table: the study's runs, whole models; its column `ended` ("plateau", "cap" or "search"),
            if there is one, says why training ended.
    """
    without_cycle = table["limit_cycle_share"] == 0.0
    never_hops = without_cycle & (table["best_fitness"] <= NO_HOP)
    ended = table.columns.get("ended")
    local = cap = None
    if ended is not None:
        fitness = table["best_fitness"]
        best = np.zeros(len(table))
        for model in np.unique(table["model"]):
            rows = table["model"] == model
            best[rows] = fitness[rows].max()
        # ΔΩ may make a best fitness negative: no optimum was found then, nor missed.
        below = (best > 0.0) & (fitness < LOCAL_OPTIMUM * best)
        local = int((below & (ended == "plateau") & ~never_hops).sum())
        cap = int((ended == "cap").sum())
    return RunEndings(len(table), int(never_hops.sum()), local, cap, int(without_cycle.sum()))


def endings_by_architecture(table: StudyTable) -> dict[str, RunEndings]:
    """Return the endings for each architecture, in the order of the table, and for all as "all"."""
    names = list(dict.fromkeys(table["architecture"].tolist()))
    return {name: endings(table.where(architecture=name)) for name in names} | {
        "all": endings(table)
    }
