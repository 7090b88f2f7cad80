"""Learning curves of any algorithm, read from what trainings left, on the same two scales."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import numbers, read_csv
from tegotae._support.workplace import is_earlier
from tegotae.training.run import curves_of, run_document

COT, FITNESS = "cot_inverse", "fitness"
"""What a learning curve can be of: CoT⁻¹, or the fitness that was trained."""
COLUMNS = ("algorithm", "model", "seed", "episode", "simulated_s", COT)
"""Columns of a table of learning curves, one row a point; of the fitness the last is `fitness`."""

LATE = 0.1
"""Share of a run that its late mean is over."""


@dataclass(frozen=True)
class LearningCurve:
    """CoT⁻¹, or the fitness, of the policy in the course of one run, shape [points] each.

    Args:
        algorithm: which, and what sets it apart from others of the same name.
        model: the model's name.
        seed: the run's.
        episode: where in training, as the paper counts: episodes of an agent, generations of an
            evolution.
        simulated_s: simulated time that was learned from until there [s]; evaluations, which
            nothing is learned from, do not count.
        value: of the deterministic policy, or of the distribution's mean: CoT⁻¹ over the settled
            part of an undisturbed episode [m/J], or the fitness.
        measure: which of them, "cot_inverse" or "fitness".
    """

    algorithm: str
    model: str
    seed: int
    episode: np.ndarray
    simulated_s: np.ndarray
    value: np.ndarray
    measure: str = COT

    def late_mean(self, until_s: float = np.inf) -> float:
        """Mean over the last tenth of the run, or of its part until `until_s`."""
        time = self.simulated_s[self.simulated_s <= until_s]
        late = time >= (1.0 - LATE) * time[-1]
        return float(self.value[: len(time)][late].mean())


def read_curves(places: Sequence[Path], measure: str | None = COT) -> list[LearningCurve]:
    """The learning curves at some places, ordered by model, algorithm and seed.

    Args:
        places: folders of trainings, searched with their subfolders, and tables (.csv) such as
            `tegotae figure learning-curves` writes.
        measure: what they are of, "cot_inverse" or "fitness"; None for CoT⁻¹ if all trainings
            measured it, and else the fitness.

    Raises:
        TegotaeError: if there are none, a file is damaged, or two runs cannot be distinguished.
    """
    curves = [curve for place in places if place.suffix == ".csv" for curve in _in_table(place)]
    trainings = [t for place in places if place.suffix != ".csv" for t in _in_folder(place)]
    if measure is None:
        known = [bool(points[COT].notna().any()) for *_, points in trainings]
        measure = COT if all(known + [curve.measure == COT for curve in curves]) else FITNESS
    if others := {curve.measure for curve in curves} - {measure}:
        raise TegotaeError(f"a table contains the {others.pop()}, not the {measure}")
    curves = sorted([*curves, *_labelled(trainings, measure)], key=_identity)
    for first, second in pairwise(curves):
        if _identity(first) == _identity(second):
            raise TegotaeError(
                f"there are two runs of {first.algorithm} on {first.model} with seed {first.seed}; "
                "draw their folders apart"
            )
    return curves


def longest_s(folder: Path) -> float:
    """Simulated time from which the longest run of a training has learned [s].

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


def groups(curves: Iterable[LearningCurve]) -> dict[tuple[str, str], list[LearningCurve]]:
    """Runs of the same model and algorithm together, by (model, algorithm)."""
    together: dict[tuple[str, str], list[LearningCurve]] = {}
    for curve in curves:
        together.setdefault((curve.model, curve.algorithm), []).append(curve)
    return together


def shared(curves: Sequence[LearningCurve]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The points that all of some runs have: episode, simulated time [s], values [points, runs].

    Raises:
        TegotaeError: if there are none.
    """
    episode = curves[0].episode
    for curve in curves[1:]:
        episode = np.intersect1d(episode, curve.episode)
    if len(episode) == 0:
        first = curves[0]
        raise TegotaeError(f"the runs of {first.algorithm} on {first.model} share no episode")
    rows = [np.isin(curve.episode, episode) for curve in curves]
    values = [curve.value[row] for curve, row in zip(curves, rows, strict=True)]
    return episode, curves[0].simulated_s[rows[0]], np.stack(values, axis=1)


def table(curves: Sequence[LearningCurve]) -> pd.DataFrame:
    """All points of all runs, in the columns `COLUMNS`."""
    frames = [pd.DataFrame({**vars(curve)}).drop(columns="measure") for curve in curves]
    return pd.concat(frames, ignore_index=True).rename(columns={"value": curves[0].measure})


def _identity(curve: LearningCurve) -> tuple[str, str, int]:
    return curve.model, curve.algorithm, curve.seed


_Training: TypeAlias = tuple[Path, dict[str, Any], pd.DataFrame]
"""A training's folder, its configuration, and its `curves.csv`."""


def _in_folder(place: Path) -> list[_Training]:
    """The trainings in a folder and its subfolders, but for those that were set aside."""
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


def _labelled(trainings: Sequence[_Training], measure: str) -> list[LearningCurve]:
    """The curves, each algorithm named with those settings in which it differs among them."""
    curves: list[LearningCurve] = []
    for folder, run, points in trainings:
        if measure == COT and np.isnan(points[COT]).all():
            raise TegotaeError(
                f"{folder} measured no CoT⁻¹, of which these curves are; draw the fitness that "
                "was trained: --of fitness"
            )
        settings = run["algorithm"]
        alike = [t["algorithm"] for _, t, _ in trainings]
        alike = [other for other in alike if other["name"] == settings["name"]]
        label = str(settings["name"])
        for name, value in settings.items():
            if any(other.get(name) != value for other in alike):
                words = "+".join(map(str, value)) or "none" if isinstance(value, list) else value
                label += f", {name} {words}"
        labelled = points.assign(algorithm=label, model=run["experiment"]["name"])
        curves += _runs(labelled.rename(columns={"step": "episode"}), measure)
    return curves


def _in_table(path: Path) -> list[LearningCurve]:
    """The curves of a table (`table`)."""
    kind = "table of learning curves"
    cells = read_csv(path, COLUMNS[:-1], kind=kind)
    measure = FITNESS if FITNESS in cells else COT
    try:
        columns = {name: numbers(cells[name]) for name in ("episode", "simulated_s", measure)}
        seeds = [int(cell) for cell in cells["seed"]]
    except (KeyError, ValueError):
        raise TegotaeError(f"{path} is no {kind}; its columns are {', '.join(COLUMNS)}") from None
    return _runs(pd.DataFrame({**cells, **columns, "seed": seeds}), measure)


def _runs(points: pd.DataFrame, measure: str) -> list[LearningCurve]:
    """The run of each algorithm, model and seed of a table."""
    return [
        LearningCurve(algorithm, model, int(seed), episode, time, value, measure)
        for (algorithm, model, seed), run in points.groupby(list(COLUMNS[:3]), sort=False)  # type: ignore[misc]
        for episode, time, value in [(run[c].to_numpy() for c in (*COLUMNS[3:5], measure))]
    ]
