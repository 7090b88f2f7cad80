"""Convergence of the study's trainings, architecture by architecture."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from research.reproduction.figures.convergence import (
    Trainings,
    convergence_figure,
    convergence_table,
)
from research.reproduction.record import Record
from research.reproduction.table import record_place

POINTS = 60
"""Points of a curve, evenly spaced in the logarithm of the episodes."""


def trainings(records: Iterable[Record]) -> dict[tuple[str, float | None], Trainings]:
    """Return the learning curves of all trained models, by architecture and ω_t [rad/s].

    A single network has no ω_t. Runs of all models of an architecture stand side by side.

    Args:
        records: of one study: all with the same population.
    """
    groups: dict[tuple[str, float | None], list[Record]] = {}
    for record in records:
        if record.curves:
            stands = record_place(record)
            omega_t = None if np.isnan(stands["omega_t"]) else stands["omega_t"]
            groups.setdefault((stands["architecture"], omega_t), []).append(record)
    return {key: _join_records(group) for key, group in groups.items()}


def convergence_figures(records: Iterable[Record]) -> dict[str, Figure]:
    """Draw the convergence at each ω_t, by its label, such as "4"; T stands with each.

    Nothing where nothing is trained.
    """
    by_model = trainings(records)
    alone = {name: training for (name, omega_t), training in by_model.items() if omega_t is None}
    omegas = sorted({omega_t for _, omega_t in by_model if omega_t is not None})
    return {
        f"{omega:g}": convergence_figure(
            {name: training for (name, omega_t), training in by_model.items() if omega_t == omega}
            | alone
        )
        for omega in omegas
    }


def convergence_means(records: Iterable[Record]) -> dict[str, np.ndarray]:
    """Return the means in the pictures, one row per architecture, ω_t and number of episodes."""
    by_model = trainings(records)
    parts = [
        {"omega_t": np.full(len(rows["name"]), np.nan if omega_t is None else omega_t)} | rows
        for (name, omega_t), training in by_model.items()
        for rows in [convergence_table({name: training})]
    ]
    return {column: np.concatenate([part[column] for part in parts]) for column in parts[0]}


def _join_records(records: list[Record]) -> Trainings:
    longest = max(len(record.curves["centre_fitness"]) for record in records)
    # The row of a generation is of the distribution that it began with.
    points = np.unique(np.geomspace(1, longest, POINTS).round().astype(int))
    curves = []
    for record in records:
        fitness = record.curves["centre_fitness"].astype(float)
        ended = np.full((longest - len(fitness), fitness.shape[1]), np.nan)
        curves.append(np.concatenate([fitness, ended]))
    # The best of a stretch between two points stands at its end, so that no best is left out.
    best = np.fmax.accumulate(np.concatenate(curves, axis=1), axis=0)
    runs = np.concatenate([record.generations for record in records])
    visible = np.where(points[:, None] <= runs[None], best[points - 1], np.nan)
    # A run that ended between two points is shown to the next.
    for run, last in enumerate(runs):
        visible[np.searchsorted(points, last), run] = best[last - 1, run]
    population = records[0].population
    return Trainings(
        points * population,
        visible,
        runs * population,
        tuple(str(reason) for record in records for reason in record.ended),
    )
