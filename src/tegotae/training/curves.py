"""Learning curves of any algorithm, read from what trainings left, on the same two scales."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError
from tegotae._support.tables import numbers, parse_csv
from tegotae._support.workplace import is_earlier
from tegotae.training.folder import ExperimentEntry, RunDocument
from tegotae.training.learner import curves_of

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
    trainings: list[_Training] = []
    tables: list[LearningCurve] = []
    for place in places:
        if place.suffix == ".csv":
            tables += _from_table(place)
        else:
            found = [_Training.read(path) for path in _folders(place)]
            if not found:
                raise TegotaeError(f"{place} holds no learning curves (run.json and curves.csv)")
            trainings += found
    if measure is None:
        known = all(each.measured_cot for each in trainings)
        measure = COT if known and all(each.measure == COT for each in tables) else FITNESS
    for each in tables:
        if each.measure != measure:
            raise TegotaeError(f"a table contains the {each.measure}, not the {measure}")
    curves = [*tables, *_labelled(trainings, measure)]
    curves.sort(key=lambda curve: (curve.model, curve.algorithm, curve.seed))
    for first, second in pairwise(curves):
        if _identity(first) == _identity(second):
            raise TegotaeError(
                f"there are two runs of {first.algorithm} on {first.model} with seed {first.seed}; "
                "draw their folders apart"
            )
    return curves


def groups(curves: Iterable[LearningCurve]) -> dict[tuple[str, str], list[LearningCurve]]:
    """Runs of the same model and algorithm together, by (model, algorithm)."""
    found: dict[tuple[str, str], list[LearningCurve]] = {}
    for curve in curves:
        found.setdefault((curve.model, curve.algorithm), []).append(curve)
    return found


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


def table(curves: Sequence[LearningCurve]) -> dict[str, np.ndarray]:
    """All points of all runs, in the columns `COLUMNS`."""
    lengths = [len(curve.episode) for curve in curves]
    whose = {
        name: np.repeat([getattr(curve, name) for curve in curves], lengths)
        for name in ("algorithm", "model", "seed")
    }
    points = {
        column: np.concatenate([getattr(curve, name) for curve in curves])
        for column, name in [
            ("episode", "episode"),
            ("simulated_s", "simulated_s"),
            (curves[0].measure, "value"),
        ]
    }
    return {**whose, **points}


class _AlgorithmEntry(msgspec.Struct):
    name: str
    population: Annotated[int, msgspec.Meta(ge=1)] = 1


class _Trained(msgspec.Struct):
    """The entries read from a training's configuration."""

    experiment: ExperimentEntry
    algorithm: _AlgorithmEntry


@dataclass(frozen=True)
class _Training:
    """What a training left in its folder."""

    configuration: dict[str, Any]
    columns: Mapping[str, np.ndarray]
    """Of `curves.csv` (`tegotae.training.learner`)."""
    path: Path

    @classmethod
    def read(cls, folder: Path) -> _Training:
        path, curves = folder / "run.json", folder / "curves.csv"
        try:
            configuration = documents.fitted(documents.read(path), RunDocument).configuration
            documents.fitted(configuration, _Trained)
        except DamagedDocumentError as error:
            raise TegotaeError(f"{path} is damaged: {error}") from None
        except OSError as error:
            raise TegotaeError(f"cannot read {error.filename}: {error.strerror}") from None
        return cls(configuration, curves_of(curves), folder)

    @property
    def settings(self) -> Mapping[str, object]:
        """Those of the algorithm, with its name."""
        return self.configuration["algorithm"]

    @property
    def model(self) -> str:
        """The experiment's name."""
        return self.configuration["experiment"]["name"]

    @property
    def measured_cot(self) -> bool:
        """Whether CoT⁻¹ was measured at all."""
        return not np.isnan(self.columns[COT]).all()

    def curves(self, label: str, measure: str) -> list[LearningCurve]:
        """One curve per seed."""
        if measure == COT and not self.measured_cot:
            raise TegotaeError(
                f"{self.path} measured no CoT⁻¹, of which these curves are; draw the fitness that "
                "was trained: --of fitness"
            )
        seeds = self.columns["seed"]
        shown = [self.columns[name] for name in ("step", "simulated_s", measure)]
        return [
            LearningCurve(
                label,
                self.model,
                int(seed),
                *(column[seeds == seed] for column in shown),
                measure=measure,
            )
            for seed in dict.fromkeys(seeds.tolist())
        ]


def _identity(curve: LearningCurve) -> tuple[str, str, int]:
    return curve.model, curve.algorithm, curve.seed


def _folders(place: Path) -> list[Path]:
    if not place.is_dir():
        raise TegotaeError(f"there is no folder {place}")
    found = [
        p.parent for p in sorted(place.rglob("curves.csv")) if (p.parent / "run.json").exists()
    ]
    return [p for p in found if not any(map(is_earlier, p.relative_to(place).parts))]


def _rows(path: Path) -> list[dict[str, str]]:
    columns = parse_csv(path.read_text(encoding="utf-8"))
    return [
        dict(zip(columns, map(str, cells), strict=True))
        for cells in zip(*columns.values(), strict=True)
    ]


def _labelled(trainings: Sequence[_Training], measure: str) -> list[LearningCurve]:
    """The curves, each algorithm named with those settings in which it differs among them."""
    curves = []
    for training in trainings:
        try:
            own = training.settings
            label = str(own["name"])
            others = [t.settings for t in trainings if t.settings["name"] == own["name"]]
            for name, value in own.items():
                if any(other.get(name) != value for other in others):
                    label += f", {name} {_words(value)}"
            curves += training.curves(label, measure)
        except TegotaeError:
            raise
        except (KeyError, ValueError, TypeError) as error:
            raise TegotaeError(f"{training.path} is damaged: {error!r}") from None
    return curves


def _words(value: object) -> str:
    return ("+".join(map(str, value)) or "none") if isinstance(value, list) else str(value)


def _from_table(path: Path) -> list[LearningCurve]:
    points: dict[tuple[str, str, int], list[tuple[float, ...]]] = {}
    try:
        rows = _rows(path)
        measure = FITNESS if rows and FITNESS in rows[0] else COT
        for row in rows:
            key = (row["algorithm"], row["model"], int(row["seed"]))
            read = numbers(row[name] for name in ("episode", "simulated_s", measure))
            points.setdefault(key, []).append(tuple(read))
    except FileNotFoundError:
        raise TegotaeError(f"there is no table {path}") from None
    except (OSError, ValueError, KeyError):
        raise TegotaeError(
            f"{path} is no table of learning curves; its columns are {', '.join(COLUMNS)}"
        ) from None
    return [
        LearningCurve(algorithm, model, seed, *np.array(found).T, measure=measure)
        for (algorithm, model, seed), found in points.items()
    ]
