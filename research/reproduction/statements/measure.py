"""The study's kept controllers, measured again: pushes, and hopping without the feedback."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pandas as pd

from research.reproduction.statements.push import PUSH, push_metrics
from research.reproduction.unit import drawn_start
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.statistics import mean_defined
from tegotae.parts.held import with_held_feedback
from tegotae.systems.recipe import recipe
from tegotae.systems.zoo import study_of

OF_PUSHES = ("V", "VG", "AR", "ART", "ARG", "ARGT")
"""The architectures whose pushes the paper describes; on [F_k] alone."""
_PROTOCOL = Protocol(drop_m=0.0)
_SETTLED = "limit_cycle_share"


def measure_models(study: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Measure the models that the file lacks, and return its table, a row per model and run.

    Args:
        study: the study's runs, as `export` writes them.
        file: the table, written after every model; what it has is not measured again.
    """
    tables = [pd.read_csv(file)] if file.exists() else []
    measured_models = set(tables[0].model) if tables else set()
    for model, runs in study.groupby("model", sort=False):
        if model in measured_models or runs.architecture.iloc[0] == "T":
            continue
        begun = time.monotonic()
        tables.append(_measured(str(model), runs))
        pd.concat(tables, ignore_index=True).to_csv(file, index=False, float_format="%.6g")
        print(f"{model}: {time.monotonic() - begun:.0f} s", flush=True)
    table = pd.concat(tables, ignore_index=True)
    places = {model: i for i, model in enumerate(study.model.unique())}
    table = table.sort_values(
        ["model", "run"], key=lambda x: x.map(places) if x.name == "model" else x
    )
    table.to_csv(file, index=False, float_format="%.6g")
    return table


def _measured(model: str, runs: pd.DataFrame) -> pd.DataFrame:
    first = runs.iloc[0]
    experiment = recipe(model).experiment()
    weights = study_of("paper").weights(model)
    start = experiment.system.scenario()
    if first.architecture == "V":
        start = drawn_start(start, len(weights))
    pushes = first.architecture in OF_PUSHES and first.observation == "F"
    columns: dict[str, np.ndarray] = {}
    with push_metrics():
        settings = {"start": start, "integrator": experiment.system.integrator}
        setting = (experiment.omega, experiment.body, _PROTOCOL)
        if pushes:
            evaluation = evaluate(
                experiment.controller, weights, *setting, [x.name for x in PUSH], **settings
            )
            columns |= {x.name: mean_defined(evaluation.episodes[x.name]) for x in PUSH[:3]}
            cos, sin = (evaluation.episodes[x.name] for x in PUSH[3:])
            columns["onset_spread"] = spread(cos, sin)
        clock, cut = with_held_feedback(experiment.controller, weights)
        columns["settled_cut"] = mean_defined(
            evaluate(clock, cut, *setting, [_SETTLED], **settings).episodes[_SETTLED]
        )
    settled = pd.DataFrame(runs[[*_KEYS]]).rename(columns={"limit_cycle_share": "settled"})
    return settled.reset_index(drop=True).assign(**columns)


_KEYS = (
    *("model", "architecture", "observation", "actuation", "omega_t", "run", "best_fitness"),
    "limit_cycle_share",
)


def spread(cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    """Return the spread of the phase of the onset over the frequencies, [runs]: 0 for pushes that
    begin at one phase, 1 for phases anywhere; NaN for fewer than two settled episodes.
    """
    spread = 1.0 - np.hypot(mean_defined(cos), mean_defined(sin))
    return np.where(np.isfinite(cos).sum(axis=1) > 1, spread, np.nan)
