"""Each model by itself: the numbers of its runs, and the hop and surface of its best one."""

from __future__ import annotations

import base64
from collections.abc import Mapping

import numpy as np

from research.reproduction.best_gait import LAST_S, best_run, recorded_controller, recorded_orbit
from research.reproduction.figures.study import architectures
from research.reproduction.record import Record
from research.reproduction.report.values import json_number
from research.reproduction.table import StudyTable, with_derived
from tegotae._support.documents import JsonObject
from tegotae.analysis.orbit import NoLimitCycleError, find_orbit
from tegotae.analysis.surface import actuation_surface
from tegotae.measures.statistics import mean_defined
from tegotae.parts.bodies import Hopper
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.controller_file import SavedController

_UNTIL_S = 30.0
_ROWS, _COLUMNS = 36, 56
"""Size of a surface: a page holds that of every model, so that each has to be small."""


def best_of_architectures(table: StudyTable) -> dict[str, str]:
    """Return the model whose run has the highest fitness, of every architecture that has runs."""
    names = {}
    for architecture in architectures(table):
        rows = np.flatnonzero(table["architecture"] == architecture)
        if not len(rows):
            continue
        names[architecture] = str(table["model"][rows[np.argmax(table["best_fitness"][rows])]])
    return names


def pages_of_models(
    records: list[Record], table: StudyTable, metrics: tuple[str, ...]
) -> dict[str, JsonObject]:
    """Return the report's pages of the models, by name.

    It draws hoppers; of what was trained on another body it shows the numbers alone.

    Args:
        records: the study's records.
        table: their table.
        metrics: columns of the table whose value in every run is shown.
    """
    pages = {}
    for record in records:
        rows = table["model"] == record.model
        run = best_run(record.best_fitness)
        pages[record.model] = {
            "run": run,
            "metrics": [[_short(value) for value in table[name][rows]] for name in metrics],
        }
        saved = recorded_controller(record, run)
        if isinstance(saved.body, Hopper):
            has_cycle, gait = _gait(record, saved)
            pages[record.model] |= {
                "has_cycle": has_cycle,
                "hop": _hop(saved, gait),
                "surface": _surface(saved, gait),
            }
    return pages


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
    is_known = np.isfinite(share) & (period == 1.0)
    return rate[is_known], cot[is_known]


def _gait(record: Record, saved: SavedController) -> tuple[bool, Mapping[str, np.ndarray]]:
    """Return whether the best run has a limit cycle, and the channels of its last seconds.

    A record without an episode at the training frequency does not hold them: it is rolled out.
    """
    if record.gait:
        return recorded_orbit(record) is not None, record.gait
    assert isinstance(saved.body, Hopper)
    try:
        find_orbit(saved)
        has_cycle = True
    except NoLimitCycleError:
        has_cycle = False
    timing = Timing(duration_s=_UNTIL_S)
    rollout = Rollout(controller=saved.controller, timing=timing)
    path = rollout.run(saved.weights, Scenario.at_frequency(saved.omega), saved.body)
    last = slice(-round(LAST_S / timing.frame_s), None)
    return has_cycle, {name: x[last, 0] for name, x in path.channels.items()}


def _surface(saved: SavedController, gait: Mapping[str, np.ndarray]) -> JsonObject:
    """Return the actuator force over phase (or velocity) and spring force, a little beyond the
    gait's.
    """
    body = saved.body
    assert isinstance(body, Hopper)
    largest_n = float(gait["spring_force_n"].max())
    fastest = max(4.0, 1.05 * float(np.abs(gait["velocity_m_per_s"]).max()))
    limit_n = 1.1 * largest_n if largest_n > 0.0 else 3.5 * body.weight_n
    limit_n = min(limit_n, body.most_spring_n)
    surface = actuation_surface(
        saved,
        np.linspace(0.0, limit_n, _ROWS),
        columns=_COLUMNS,
        velocity_range_m_per_s=(-fastest, fastest),
    )
    with_phase = surface.phase_rad is not None
    across = surface.phase_rad if surface.phase_rad is not None else surface.velocity_m_per_s
    return {
        "across": "phase" if with_phase else "velocity",
        "from": json_number(float(across[0])),
        "to": json_number(float(across[-1])),
        "most": json_number(limit_n),
        "rows": _ROWS,
        "columns": _COLUMNS,
        "force": _packed(surface.actuator_force_n.ravel(), "uint8"),
    }


def _hop(saved: SavedController, gait: Mapping[str, np.ndarray]) -> JsonObject:
    """Return the last seconds of a gait, for the page's canvas."""
    assert isinstance(saved.body, Hopper)
    frame_s = Timing().frame_s
    channels = {
        "height": _packed(gait["height_m"], "uint16"),
        "force": _packed(gait["actuator_force_n"], "uint8"),
        "spring": _packed(gait["spring_force_n"], "uint8"),
    }
    if saved.controller.oscillator is None:
        channels["velocity"] = _packed(gait["velocity_m_per_s"], "uint8")
    else:
        channels["phase"] = _packed(np.mod(gait["phase_rad"], 2.0 * np.pi), "uint8")
        channels["feedback"] = _packed(gait["feedback_rad_per_s"], "uint8")
    return {
        "per_s": round(1.0 / frame_s),
        "from_s": round(float(gait["time_s"][0]) - frame_s, 3),
        "rest_length": saved.body.rest_length_m,
        "max_force": saved.body.max_force_n,
        "channels": channels,
    }


def _short(value: float) -> float | None:
    return None if (parsed := json_number(value)) is None else float(f"{parsed:.3g}")


def _packed(values: np.ndarray, kind: str) -> JsonObject:
    """Return numbers as steps between the smallest and the largest, which the page unpacks."""
    values = np.nan_to_num(np.asarray(values, float))
    low, high = float(values.min()), float(values.max())
    steps = np.iinfo(kind).max
    scaled = np.round((values - low) / ((high - low) or 1.0) * steps).astype(np.dtype(kind))
    content = base64.b64encode(scaled.astype(scaled.dtype.newbyteorder("<")).tobytes()).decode()
    return {
        "low": json_number(low),
        "high": json_number(high),
        "bits": scaled.dtype.itemsize * 8,
        "at": content,
    }
