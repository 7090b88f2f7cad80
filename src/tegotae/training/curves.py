"""Learning curves of any algorithm, read from what trainings left, on the same two scales."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_numbers, read_csv
from tegotae._support.workplace import is_earlier
from tegotae.training.run import curves_of, run_document

COT, FITNESS = "cot_inverse", "fitness"
"""Quantities of a learning curve: CoT⁻¹, or the fitness that was trained."""
COLUMNS = ("algorithm", "model", "seed", "episode", "simulated_s", COT)
"""Columns of a table of learning curves, one row a point; of the fitness the last is `fitness`."""

LATE = 0.1
"""Share of a run that its late mean is over."""


_RUN = ["model", "algorithm", "seed"]


def read_curves(places: Sequence[Path], measure: str | None = COT) -> pd.DataFrame:
    """Read the learning curves at some places, one row per point, ordered by model, algorithm and
    seed.

    The columns are `COLUMNS`: `algorithm`, which and what sets it apart from others of the same
    name; the `model`; the run's `seed`; `episode`, where in training, as the paper counts: episodes
    of an agent, generations of an evolution; `simulated_s`, the simulated time that was learned
    from until there [s], without evaluations; and of the deterministic policy, or the
    distribution's mean, CoT⁻¹ over the settled part of an undisturbed episode [m/J], or `fitness`.

    Args:
        places: folders of trainings, searched with their subfolders, and tables (.csv) such as
            `tegotae figure learning-curves` writes.
        measure: what they are of, "cot_inverse" or "fitness"; None for CoT⁻¹ if all trainings
            measured it, and else the fitness.

    Raises:
        TegotaeError: if there are none, a file is damaged, or two runs cannot be distinguished.
    """
    tables = [_in_table(place) for place in places if place.suffix == ".csv"]
    trainings = [t for place in places if place.suffix != ".csv" for t in _in_folder(place)]
    if measure is None:
        has_cot = [bool(points[COT].notna().any()) for *_, points in trainings]
        measure = COT if all(has_cot + [COT in table for table in tables]) else FITNESS
    for table in tables:
        if measure not in table:
            raise TegotaeError(f"a table contains the {measure_of(table)}, not the {measure}")
    sources = [*tables, *_labelled(trainings, measure)]
    runs = pd.concat([source[_RUN].drop_duplicates() for source in sources])
    for model, algorithm, seed in runs.loc[runs.duplicated()].to_numpy().tolist():
        raise TegotaeError(
            f"there are two runs of {algorithm} on {model} with seed {seed}; draw their folders "
            "apart"
        )
    return pd.concat(sources).sort_values(_RUN, kind="stable", ignore_index=True)


def measure_of(curves: pd.DataFrame) -> str:
    """Return the quantity of learning curves, "cot_inverse" or "fitness"."""
    return str(curves.columns[-1])


def late_mean(run: pd.DataFrame, until_s: float = np.inf) -> float:
    """Return the mean of one run over the last tenth, or that of its part until `until_s`."""
    time = run["simulated_s"].to_numpy()
    time = time[time <= until_s]
    late = time >= (1.0 - LATE) * time[-1]
    return float(run[measure_of(run)].to_numpy()[: len(time)][late].mean())


def longest_s(folder: Path) -> float:
    """Return the simulated time from which the longest run of a training has learned [s].

    Raises:
        TegotaeError: for a folder without the learning curves of a training.
    """
    if not (folder / "curves.csv").is_file():
        raise TegotaeError(f"{folder} holds no training to learn as long as; it has no curves.csv")
    points = curves_of(folder / "curves.csv")
    times = np.unique(points["simulated_s"])
    if len(times) < 2:
        return 0.0
    # A point of a population is at the beginning of its generation.
    of_population = bool(points["best_fitness"].notna().any())
    return float(times[-1] + of_population * (times[-1] - times[-2]))


def groups(curves: pd.DataFrame) -> dict[tuple[str, str], list[pd.DataFrame]]:
    """Return the runs of the same model and algorithm together, by (model, algorithm)."""
    together: dict[tuple[str, str], list[pd.DataFrame]] = {}
    for (model, algorithm, _), run in curves.groupby(_RUN, sort=False):  # type: ignore[misc]
        together.setdefault((model, algorithm), []).append(run)
    return together


def shared(runs: Sequence[pd.DataFrame]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points that some runs have in common: episode, simulated time [s], values [points,
    runs].

    Raises:
        TegotaeError: if there are none.
    """
    episode = reduce(np.intersect1d, [run["episode"].to_numpy() for run in runs])
    if len(episode) == 0:
        first = runs[0].iloc[0]
        raise TegotaeError(f"the runs of {first.algorithm} on {first.model} share no episode")
    rows = [run.loc[np.isin(run["episode"], episode)] for run in runs]
    values = np.stack([row[measure_of(row)] for row in rows], axis=1)
    return episode, rows[0]["simulated_s"].to_numpy(), values


_Training: TypeAlias = tuple[Path, dict[str, Any], pd.DataFrame]
"""A training's folder, its configuration, and its `curves.csv`."""


def _in_folder(place: Path) -> list[_Training]:
    """Return the trainings in a folder and its subfolders, except those set aside."""
    if not place.is_dir():
        raise TegotaeError(f"there is no folder {place}")
    trainings = [
        (path.parent, run_document(path.parent)["configuration"], curves_of(path))
        for path in sorted(place.rglob("curves.csv"))
        if (path.parent / "run.json").exists()
        and not any(map(is_earlier, path.parent.relative_to(place).parts))
    ]
    if not trainings:
        raise TegotaeError(f"{place} holds no learning curves (run.json and curves.csv)")
    return trainings


def _labelled(trainings: Sequence[_Training], measure: str) -> Iterator[pd.DataFrame]:
    """Yield the curves, each algorithm named with those settings in which it differs from the
    others.
    """
    for folder, run, points in trainings:
        if measure == COT and np.isnan(points[COT]).all():
            raise TegotaeError(
                f"{folder} measured no CoT⁻¹, of which these curves are; draw the fitness that "
                "was trained: --of fitness"
            )
        settings = run["algorithm"]
        algorithms = [t["algorithm"] for _, t, _ in trainings]
        algorithms = [
            algorithm for algorithm in algorithms if algorithm["name"] == settings["name"]
        ]
        label = str(settings["name"])
        for name, value in settings.items():
            if any(algorithm.get(name) != value for algorithm in algorithms):
                words = "+".join(map(str, value)) or "none" if isinstance(value, list) else value
                label += f", {name} {words}"
        model = run["experiment"]["name"]
        labelled = points.assign(algorithm=label, model=model, seed=points["seed"].astype(int))
        renamed = labelled.rename(columns={"step": "episode"})
        yield renamed.reindex(columns=[*COLUMNS[:-1], measure])


def _in_table(path: Path) -> pd.DataFrame:
    """Return the curves of a table, as `read_curves` returns them."""
    kind = "table of learning curves"
    cells = read_csv(path, COLUMNS[:-1], kind=kind)
    measure = FITNESS if FITNESS in cells else COT
    try:
        columns = {name: parse_numbers(cells[name]) for name in ("episode", "simulated_s", measure)}
        columns["seed"] = np.array([int(cell) for cell in cells["seed"]])
    except (KeyError, ValueError):
        raise TegotaeError(f"{path} is no {kind}; its columns are {', '.join(COLUMNS)}") from None
    return pd.DataFrame({**cells, **columns}, columns=[*COLUMNS[:-1], measure])
