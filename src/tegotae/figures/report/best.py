"""The best controller of an architecture: its numbers, its surface and its hop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae.figures.report.values import embedded_figure, number
from tegotae.figures.study import architectures
from tegotae.figures.surface import surface_figure
from tegotae.measures.hopping.statistics import mean_defined
from tegotae.parts.bodies import Hopper
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.studies.analysis.orbit import NoLimitCycleError, Orbit, find_orbit
from tegotae.studies.analysis.surface import actuation_surface
from tegotae.studies.paper.best_gait import LAST_S, best_run, controller_of, orbit_of
from tegotae.studies.paper.record import Record
from tegotae.studies.paper.table import Table, with_derived
from tegotae.systems.controller_file import SavedController
from tegotae.systems.simulation import Simulation

_UNTIL_S = 30.0


def best_controllers(
    records: list[Record], table: Table, metrics: tuple[str, ...]
) -> dict[str, JsonObject]:
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
        if row is None:
            continue
        name, run = str(table["model"][row]), int(table["run"][row])
        record = next(record for record in records if record.model == name)
        saved = controller_of(record, run)
        if isinstance(saved.body, Hopper):
            orbit, gait = _gait(record, run, saved)
            found[architecture] = {
                "model": saved.name,
                "run": run,
                "metrics": [number(float(table[name][row])) for name in metrics],
                "surface": _surface(saved, orbit),
                "hop": _hop(saved, gait),
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


def _gait(
    record: Record, run: int, saved: SavedController
) -> tuple[Orbit | None, Mapping[str, np.ndarray]]:
    """The run's limit cycle, if there is one, and the channels of its last seconds.

    Records of earlier versions do not hold them: it is rolled out again.
    """
    assert isinstance(saved.body, Hopper)
    if record.gait and run == best_run(record.best_fitness):
        return orbit_of(record), record.gait
    try:
        orbit = find_orbit(saved)
    except NoLimitCycleError:
        orbit = None
    timing = Timing(duration_s=_UNTIL_S)
    scenario = Scenario.of(saved.omega)
    result = Simulation(saved.controller, saved.weights, scenario, saved.body, timing).run()
    last = slice(-round(LAST_S / timing.frame_s), None)
    return orbit, {name: x[last] for name, x in result.trajectory.channels.items()}


def _surface(saved: SavedController, orbit: Orbit | None) -> JsonObject:
    assert isinstance(saved.body, Hopper)
    largest = None if orbit is None else float(orbit.spring_force_n.max())
    most = 3.5 * saved.body.weight_n if largest is None else 1.1 * largest
    most = min(most, saved.body.stiffness_n_per_m * saved.body.rest_length_m)
    surface = actuation_surface(saved, np.linspace(0.0, most, 120))
    figure = surface_figure(surface, orbit, max_force_n=saved.body.max_force_n)
    return embedded_figure(figure) | {"has_cycle": orbit is not None}


def _hop(saved: SavedController, gait: Mapping[str, np.ndarray]) -> JsonObject:
    """The last seconds of a gait, for the page's canvas."""
    assert isinstance(saved.body, Hopper)
    frame_s = Timing().frame_s

    def rounded(name: str) -> list[float]:
        return np.round(gait[name].astype(float), 4).tolist()

    return {
        "per_s": round(1.0 / frame_s),
        "from_s": round(float(gait["time_s"][0]) - frame_s, 3),
        "rest_length": saved.body.rest_length_m,
        "max_force": saved.body.max_force_n,
        "height": rounded("height_m"),
        "force": rounded("actuator_force_n"),
        "phase": None if saved.controller.oscillator is None else rounded("phase_rad"),
    }
