"""The report: figures, claims, models and the best controllers on one page without a server."""

from __future__ import annotations

import base64
import io
import json
import math
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tegotae.analysis.orbit import NoLimitCycleError, find_orbit
from tegotae.analysis.surface import actuation_surface
from tegotae.bodies import Hopper
from tegotae.controller_file import SavedController
from tegotae.figures.study import (
    ARCHITECTURES,
    architectures_figure,
    correlation_figure,
    pictograms_figure,
)
from tegotae.figures.style import styled
from tegotae.figures.surface import surface_figure
from tegotae.models import find
from tegotae.rollout import Scenario, Timing
from tegotae.simulation import Simulation
from tegotae.study.claims import Part, Verdict, verdicts
from tegotae.study.record import Record
from tegotae.study.table import Table, tabulate

_COLUMNS = {
    "model": "model",
    "cot_inverse": "CoT⁻¹ A [m/J]",
    "cot_inverse_total": "CoT⁻¹ B [m/J]",
    "t0_s": "T0 [s]",
    "t1_s": "T1 [s]",
    "delta_omega": "ΔΩ",
    "delta_w": "Δw [rad/s]",
    "cpgu": "CPGu",
    "limit_cycle_share": "limit cycles",
    "smoothness": "dF/dt [1/s]",
    "best_fitness": "fitness",
}
_HOP_S = 8.0
_FRAMES_PER_S = 50


def report(records: list[Record], about: str) -> str:
    """The page, as HTML with everything in it.

    Args:
        records: the study's records.
        about: one line on what study this is.
    """
    table = tabulate(records)
    data = {
        "about": about,
        "figures": [
            [caption, _embedded(figure)]
            for caption, figure in (
                ("I. The architectures: learned terms are filled.", pictograms_figure()),
                (
                    "II. Metrics per architecture over their largest mean, with 95 % intervals "
                    "over runs; above the bars, the share of runs that do not define a metric.",
                    architectures_figure(table),
                ),
                ("III. Correlation of the metrics over all models.", correlation_figure(table)),
            )
        ],
        "claims": [_claim(verdict) for verdict in verdicts(table)],
        "models": _models(table),
        "best": _best_controllers(records, table),
    }
    page = files("tegotae.report").joinpath("page.html").read_text(encoding="utf-8")
    # "</" would end the script element that holds the data.
    return page.replace("__DATA__", json.dumps(data).replace("</", "<\\/"))


def _embedded(figure: Figure, dpi: int = 150) -> str:
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format="png", dpi=dpi)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def _number(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None


def _claim(verdict: Verdict) -> dict[str, Any]:
    return {
        "number": verdict.number,
        "claim": verdict.claim,
        "verdict": verdict.verdict,
        "parts": [_part(part) for part in verdict.parts],
    }


def _part(part: Part) -> dict[str, Any]:
    bounds = []
    if math.isfinite(part.low):
        bounds.append(f"> {part.low:.3g}")
    if math.isfinite(part.high):
        bounds.append(f"< {part.high:.3g}")
    return {
        "what": part.what,
        "verdict": part.verdict,
        "wanted": ", ".join(bounds),
        "mean": _number(part.effect.mean),
        "low": _number(part.effect.low),
        "high": _number(part.effect.high),
        "count": part.effect.count,
        "undefined": part.effect.undefined,
    }


def _models(table: Table) -> dict[str, Any]:
    models = table.per_model()
    rows = [
        [str(models[c][i]) if c == "model" else _number(float(models[c][i])) for c in _COLUMNS]
        for i in range(len(models))
    ]
    return {"columns": list(_COLUMNS.values()), "rows": rows}


def best_controller(
    records: list[Record], table: Table, architecture: str
) -> SavedController | None:
    """The run of an architecture with the highest fitness; None if there is no run."""
    rows = table.where(architecture=architecture)
    if not len(rows):
        return None
    at = int(np.argmax(rows["best_fitness"]))
    model = find(str(rows["model"][at]))
    record = next(record for record in records if record.model == model.name)
    configuration = record.configuration
    return SavedController(
        model.controller(configuration["budget"]),
        np.asarray(record.weights[int(rows["run"][at])], float),
        model.omega_t or 0.0,
        Hopper(**configuration["hopper"]),
        model.name,
        {"seed": int(rows["run"][at]), "best_fitness": float(rows["best_fitness"][at])},
        record.software,
    )


def _best_controllers(records: list[Record], table: Table) -> dict[str, Any]:
    found = {}
    for architecture in ARCHITECTURES:
        saved = best_controller(records, table, architecture)
        if saved is not None:
            fitness = saved.training["best_fitness"]
            found[architecture] = {
                "label": f"{saved.model}, run {saved.training['seed']}, fitness {fitness:.3f}",
                "surface": _surface(saved),
                "hop": _hop(saved),
            }
    return found


def _surface(saved: SavedController) -> str:
    assert isinstance(saved.body, Hopper)
    try:
        orbit = find_orbit(saved)
        most = 1.1 * float(orbit.spring_force_n.max())
    except NoLimitCycleError:
        orbit, most = None, 3.5 * saved.body.weight_n
    most = min(most, saved.body.stiffness_n_per_m * saved.body.rest_length_m)
    surface = actuation_surface(saved, np.linspace(0.0, most, 120))
    return _embedded(surface_figure(surface, orbit, max_force_n=saved.body.max_force_n))


def _hop(saved: SavedController) -> dict[str, Any]:
    """The last seconds of a rollout, for the page's canvas."""
    assert isinstance(saved.body, Hopper)
    timing = Timing(duration_s=30.0, frame_s=1.0 / _FRAMES_PER_S)
    result = Simulation(
        saved.controller, saved.weights, Scenario(omega=saved.omega), saved.body, timing
    ).run()
    last = slice(-int(_HOP_S * _FRAMES_PER_S), None)
    t = result.trajectory

    def rounded(values: np.ndarray) -> list[float]:
        return np.round(values[last].astype(float), 4).tolist()

    return {
        "per_s": _FRAMES_PER_S,
        "rest_length": saved.body.rest_length_m,
        "height": rounded(t.height_m),
        "force": rounded(t.actuator_force_n / saved.body.max_force_n),
        "phase": None if saved.controller.oscillator is None else rounded(t.phase_rad),
    }
