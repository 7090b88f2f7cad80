"""The best controller of an architecture: its numbers, its surface and its hop."""

from __future__ import annotations

from typing import Any

import numpy as np

from tegotae.figures.report.values import embedded_figure, number
from tegotae.figures.study import architectures
from tegotae.figures.surface import surface_figure
from tegotae.measures.hopping.statistics import mean_defined
from tegotae.parts.bodies import Hopper
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.studies.analysis.orbit import NoLimitCycleError, find_orbit
from tegotae.studies.analysis.surface import actuation_surface
from tegotae.studies.paper.record import Record
from tegotae.studies.paper.table import Table, with_derived
from tegotae.systems.controller_file import SavedController
from tegotae.systems.simulation import Simulation

_HOP_S = 8.0
_UNTIL_S = 30.0
_FRAMES_PER_S = 50


def best_controllers(
    records: list[Record], table: Table, metrics: tuple[str, ...]
) -> dict[str, dict[str, Any]]:
    """What the page shows of each architecture that has runs, and of experiments beside them.

    It draws hoppers; what was trained on another body is left out.

    Args:
        records: the study's records.
        table: their table.
        metrics: columns of the table whose value for the best run is shown.
    """
    found = {}
    for architecture in architectures(table):
        row = best_row(table, architecture)
        saved = None if row is None else _controller(records, table, row)
        if row is not None and saved is not None and isinstance(saved.body, Hopper):
            found[architecture] = {
                "model": saved.name,
                "run": int(table["run"][row]),
                "metrics": [number(float(table[name][row])) for name in metrics],
                "surface": _surface(saved),
                "hop": _hop(saved),
            }
    return found


def best_row(table: Table, architecture: str) -> int | None:
    """The row of the architecture's run with the highest fitness; None if it has no run."""
    rows = np.flatnonzero(table["architecture"] == architecture)
    return int(rows[np.argmax(table["best_fitness"][rows])]) if len(rows) else None


def gaits_of_best_run(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Hop frequency [rad/s] and CoT⁻¹ [m/J] of the episodes of a model's most efficient run.

    Those of a gait that repeats itself with every hop, whose share of the optimum is known.
    """
    episodes = with_derived(record, record.episodes)
    needed = ("hop_rate", "cot_inverse", "optimum_share", "limit_cycle_period")
    if not set(needed) <= set(episodes):
        return np.array([]), np.array([])
    means = np.nan_to_num(mean_defined(episodes["cot_inverse"]), nan=-1.0)
    run = int(np.argmax(means))
    rate, cot, share, period = (episodes[name][run] for name in needed)
    known = np.isfinite(share) & (period == 1.0)
    return rate[known], cot[known]


def _controller(records: list[Record], table: Table, row: int) -> SavedController:
    name, run = str(table["model"][row]), int(table["run"][row])
    record = next(record for record in records if record.model == name)
    experiment = record.experiment
    return SavedController(
        experiment.system,
        np.asarray(record.weights[run], float),
        experiment.name,
        experiment,
        {"seed": run, "best_fitness": float(table["best_fitness"][row])},
        record.software,
    )


def _surface(saved: SavedController) -> dict[str, Any]:
    assert isinstance(saved.body, Hopper)
    try:
        orbit = find_orbit(saved)
        most = 1.1 * float(orbit.spring_force_n.max())
    except NoLimitCycleError:
        orbit, most = None, 3.5 * saved.body.weight_n
    most = min(most, saved.body.stiffness_n_per_m * saved.body.rest_length_m)
    surface = actuation_surface(saved, np.linspace(0.0, most, 120))
    figure = surface_figure(surface, orbit, max_force_n=saved.body.max_force_n)
    return embedded_figure(figure) | {"has_cycle": orbit is not None}


def _hop(saved: SavedController) -> dict[str, Any]:
    """The last seconds of a rollout, for the page's canvas."""
    assert isinstance(saved.body, Hopper)
    timing = Timing(duration_s=_UNTIL_S, frame_s=1.0 / _FRAMES_PER_S)
    result = Simulation(
        saved.controller, saved.weights, Scenario.of(saved.omega), saved.body, timing
    ).run()
    last = slice(-int(_HOP_S * _FRAMES_PER_S), None)
    t = result.trajectory

    def rounded(values: np.ndarray) -> list[float]:
        return np.round(values[last].astype(float), 4).tolist()

    return {
        "per_s": _FRAMES_PER_S,
        "from_s": _UNTIL_S - _HOP_S,
        "rest_length": saved.body.rest_length_m,
        "max_force": saved.body.max_force_n,
        "height": rounded(t.height_m),
        "force": rounded(t.actuator_force_n),
        "phase": None if saved.controller.oscillator is None else rounded(t.phase_rad),
    }
