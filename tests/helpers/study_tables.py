"""Tables of a study, made up."""

import numpy as np

from research.reproduction.table import StudyTable, design_place, table_of_runs
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.systems.recipe import study_recipes

MODELS = {
    "V-sector-w4": 0.6,
    "V-sector-w8": 0.3,
    "ART-rF-tphif-w4": 1.2,
    "ART-rF-tphif-w8": 0.45,
    "T-F": 0.0,
    "T-Fv": 1.3,
}
"""Mean CoT⁻¹ of some models [m/J]."""


def table(**changed: np.ndarray) -> StudyTable:
    """Five runs of each model that learns, whose CoT⁻¹ lie around a value of the model."""
    basis = study_recipes()

    def metrics(name: str, runs: int) -> dict[str, np.ndarray]:
        result = {metric: np.linspace(0.8, 1.0, runs) for metric in HOPPING.names()}
        result["cot_inverse"] = MODELS[name] * np.linspace(0.9, 1.1, runs)
        return result | changed

    sets = []
    for name in MODELS:
        runs = 1 if basis[name].controller().has_a_gain_alone else 5
        values = {metric: row[:runs] for metric, row in metrics(name, runs).items()}
        sets.append((design_place(basis[name]), {"best_fitness": np.zeros(runs)}, values))
    return table_of_runs(sets)


def results(
    effects: dict[str, dict[str, float]], *, noise: float = 0.02, seed: int = 0
) -> StudyTable:
    """Three runs of every model; `effects` adds to metrics by architecture (and observation)."""
    random = np.random.default_rng(seed)
    rows: dict[str, list] = {}
    for model in study_recipes().values():
        place = design_place(model)
        for run in range(3):
            row = {**place, "run": run, "best_fitness": 0.0}
            for metric in HOPPING.names():
                value = 1.0 + noise * random.normal()
                for key in (
                    place["architecture"],
                    f"{place['architecture']}/{place['observation']}",
                ):
                    value += effects.get(key, {}).get(metric, 0.0)
                row[metric] = value
            for key, value in row.items():
                rows.setdefault(key, []).append(value)
    return StudyTable({key: np.array(values) for key, values in rows.items()})
