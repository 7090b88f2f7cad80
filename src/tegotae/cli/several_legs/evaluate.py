"""How well controllers walk, from random phases, at frequencies of your choice."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.documents import JsonObject, as_json
from tegotae.cli.tables import print_rows

if TYPE_CHECKING:
    from tegotae.analysis.gaits.evaluation import GaitEvaluation
    from tegotae.systems.legged import Legged
    from tegotae.systems.resolve import Resolved


def subjects(found: Resolved) -> list[tuple[str, tuple[str, ...], Legged, np.ndarray]]:
    """Sets of controllers: name, labels of its runs, system, weights [runs, n_weights].

    Raises:
        TegotaeError: if there is none, or its body has one leg.
    """
    from tegotae.systems.legged import require_legs
    from tegotae.systems.legged_systems import settling
    from tegotae.training.collection import sets_of

    if found.legged is not None:
        return [(found.name, ("",), found.legged, np.array([found.legged.weights]))]
    require_legs(found.body)
    return [
        (
            each.name,
            each.labels,
            settling(each.system, each.weights[0]),
            each.weights,
        )
        for each in sets_of(found)
    ]


def evaluate_all(
    sets: list[tuple[str, tuple[str, ...], Legged, np.ndarray]],
    omega: tuple[float, ...],
    starts: int,
    seed: int,
) -> list[tuple[str, tuple[str, ...], GaitEvaluation]]:
    """Release all from the same random phases."""
    from tegotae.analysis.gaits.evaluation import evaluate_gaits

    return [
        (name, labels, evaluate_gaits(legged, weights, omega, starts, seed=seed))
        for name, labels, legged, weights in sets
    ]


def print_table(found: list[tuple[str, tuple[str, ...], GaitEvaluation]]) -> None:
    """A row a set and frequency."""
    titles = ("controller", "ω", "runs", "upright", "locked", "locks in", "speed", "CoT")
    print_rows((*titles, "slip", "gait"), (row for each in found for row in _rows(*each)))
    units = {each.legged.units for _, _, each in found}
    print("Lengths and times are in " + " or ".join(" and ".join(pair) for pair in units) + ".")


def listed(found: list[tuple[str, tuple[str, ...], GaitEvaluation]]) -> list[JsonObject]:
    """The rows of `columns` as JSON objects, null for what is undefined."""
    table = columns(found)
    return [
        dict(zip(table, as_json(row), strict=True)) for row in zip(*table.values(), strict=True)
    ]


def columns(
    found: list[tuple[str, tuple[str, ...], GaitEvaluation]],
) -> dict[str, list[str | float]]:
    """A row per controller and frequency."""
    rows: dict[str, list[str | float]] = {"controller": [], "run": [], "omega": []}
    for name, labels, evaluated in found:
        measures = evaluated.measures
        for run, label in enumerate(labels):
            for at, omega in enumerate(evaluated.omega):
                gait, share = evaluated.commonest(run, at)
                own = {"controller": name, "run": label, "omega": float(omega)}
                own |= {title: float(x[run, at]) for title, x in measures.items()}
                for title, value in (own | {"gait": gait, "gait_share": share}).items():
                    rows.setdefault(title, []).append(value)
    return rows


def _rows(name: str, labels: tuple[str, ...], evaluated: GaitEvaluation) -> list[tuple[str, ...]]:
    from tegotae.measures.hopping.statistics import interval

    measures = evaluated.measures
    shown = ("upright", "locked", "lock_time_s", "speed_m_per_s", "cost_of_transport", "slip")
    rows = []
    for at, omega in enumerate(evaluated.omega):
        gaits = Counter(evaluated.commonest(run, at)[0] for run in range(len(labels)))
        shares_of_gaits = ", ".join(f"{gait} ({count})" for gait, count in gaits.most_common())
        numbers = []
        for title in shown:
            own = interval(measures[title][:, at])
            sure = "" if np.isnan(own.low) else f" ({own.low:.3g} … {own.high:.3g})"
            numbers.append("–" if np.isnan(own.mean) else f"{own.mean:.3g}{sure}")
        at_omega = "–" if np.isnan(omega) else f"{omega:g}"
        rows.append((name, at_omega, str(len(labels)), *numbers, shares_of_gaits))
    return rows
