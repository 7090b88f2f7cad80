"""Outcome of a training: controllers with their curves, and sentences about them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from tegotae._support.documents import JsonObject, as_json
from tegotae.api.controllers import load
from tegotae.api.results import Files, MatplotlibFigure, Table
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.statistics import interval
from tegotae.systems.controller_file import load as load_file
from tegotae.systems.experiment import Experiment
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.curves import FITNESS, read_curves
from tegotae.training.evolution import CAP, PLATEAU, RUNNING, SEARCH
from tegotae.training.run import COLUMNS, curves_of

if TYPE_CHECKING:
    from tegotae.api.environment import EnvironmentController
    from tegotae.api.hopping import HopperController
    from tegotae.api.walking import WalkerController

_ENDED = {
    PLATEAU: "on its plateau",
    CAP: "at the cap: more generations may gain more",
    SEARCH: "found by search",
    RUNNING: "not yet",
}
"""Ends of a training, in words."""


@dataclass(frozen=True, repr=False, kw_only=True)
class TrainedControllers(Files):
    """Controllers and learning curves of a training, in a folder."""

    name: str
    """Name of the experiment."""
    folder: Path
    paths: tuple[Path, ...]
    """Controller files, one a run."""
    unit: str
    """Unit of progress: generation or episode."""
    write: Callable[[Path], None] = field(default_factory=lambda: lambda _: None, init=False)

    @classmethod
    def from_files(
        cls, name: str, folder: Path, paths: Sequence[Path], unit: str
    ) -> TrainedControllers:
        """Return the outcome of a training, with the data of its controller files.

        Args:
            name: name of the experiment.
            folder: the training's folder.
            paths: controller files, one a run.
            unit: generation or episode.
        """
        trained = cls(name=name, folder=folder, paths=tuple(paths), unit=unit)
        return replace(trained, notes=_remarks(trained))

    @cached_property
    def runs(self) -> list[Mapping[str, Any]]:
        """Outcome of each run, from its controller file."""
        return [load_file(path).training for path in self.paths]

    @property
    def controllers(self) -> HopperController | WalkerController | EnvironmentController:
        """The controllers, to be evaluated and simulated."""
        return load(self.folder)

    @property
    def table(self) -> pd.DataFrame:
        """Learning curves, one row per point; empty for a search."""
        curves = self.folder / "curves.csv"
        return curves_of(curves) if curves.exists() else pd.DataFrame(columns=COLUMNS)

    def texts(self) -> list[pd.DataFrame]:
        unit = self.unit
        rows = [
            {
                "controller": str(path),
                "fitness": f"{run['best_fitness']:.4f}",
                f"best {unit}": f"{run[f'best_{unit}']:g}",
                f"{unit}s": f"{run[f'{unit}s']:g}",
                **({"ended": _ENDED[run["ended"]]} if "ended" in run else {}),
            }
            for path, run in zip(self.paths, self.runs, strict=True)
        ]
        return [pd.DataFrame(rows).set_index("controller")]

    def to_dict(self) -> JsonObject:
        runs = [
            {"controller": str(path), **run}
            for path, run in zip(self.paths, self.runs, strict=True)
        ]
        return as_json({"name": self.name, "folder": str(self.folder), "runs": runs})

    def figures(self) -> Mapping[str, MatplotlibFigure]:
        from tegotae.figures.learning_curves import algorithms_figure

        if self.table.empty:
            return {}
        return {"curves": algorithms_figure(read_curves([self.folder], None))}

    def save(self, path: Path | str) -> list[Path]:
        """Write curves and numbers elsewhere; the training's own folder has all already.

        Args:
            path: a file or a folder, as of other results.
        """
        return [] if Path(path) == self.folder else Table.save(self, path)


def _remarks(controllers: TrainedControllers) -> list[str]:
    """Return sentences about the outcome of a training."""
    runs, unit = controllers.runs, controllers.unit
    fitness = [float(run["best_fitness"]) for run in runs]
    notes = []
    if len(fitness) > 1:
        best = interval(fitness)
        notes.append(
            f"fitness {best.mean:.4f}, 95 % interval of the mean over {len(fitness)} runs "
            f"[{best.low:.4f}, {best.high:.4f}]"
        )
    if failures := sum(x < 0.5 * FAILED_FITNESS for x in fitness):
        notes.append(
            f"{failures} of {len(fitness)} learned nothing: no candidate survived its episode, "
            "so the fitness has no other meaning."
        )
    if stuck := sum(run[f"best_{unit}"] == 0 and run[f"{unit}s"] > 20 for run in runs):
        cure = "Try a smaller --learning-rate, a smaller --noise, and more --episodes."
        if unit != AgentLearner.UNIT:
            cure = "A law of a few numbers learns with --algorithm cma-es --std 0.08."
        notes.append(
            f"{stuck} of {len(fitness)} never got better than they began; their steps may be "
            f"too large. {cure}"
        )
    return notes


def without_hops(trained: TrainedControllers, experiment: Experiment) -> list[str]:
    """Return a line on runs whose result does not hop, and a remedy.

    Args:
        trained: controllers and learning curves.
        experiment: the experiment; only of a body with one leg there is a line.
    """
    curves = trained.table
    if experiment.body.limbs > 1:
        return []
    if curves.empty:  # a search, of whose result there is no curve
        resting = sum("no hop" in " ".join(load(path).simulate().notes) for path in trained.paths)
    else:
        last = curves.groupby("seed")["cot_inverse"].nth(-1)  # which may be NaN
        resting = sum(not cot > 0.0 for cot in last.iloc[-len(trained.paths) :])
    if not resting:
        return []
    body = experiment.body
    weight_n, force_n = getattr(body, "weight_n", math.nan), float(body.max_force_n)
    return [
        f"{resting} of {len(trained.paths)} do not hop: CoT⁻¹ is 0 where they end. The body weighs "
        f"{weight_n:.3g} N and pushes with {force_n:.3g} N, and is released at "
        f"{experiment.system.release.height_m:.3g} m over a leg of {body.rest_length_m:.3g} m. Try "
        "in this order: a name with ω near √(k/m), such as -w14; ART, which learns the push; a "
        "higher --height-m" + f"; more {trained.unit}s and --seeds" * (not curves.empty) + "."
    ]


def advice(trained: TrainedControllers, *, tolerance: float) -> list[str]:
    """Return the reason that a body never leaves the ground, and remedies where no run gained much.

    Args:
        trained: controllers and learning curves.
        tolerance: smallest gain that counts.
    """
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.environments.replay import replay

    sentences = []
    best = max(map(load_file, trained.paths), key=lambda run: float(run.training["best_fitness"]))  # type: ignore[arg-type]
    experiment = EnvExperiment.from_controller(best)
    if experiment.spec.is_model and (
        reason := replay(experiment, [best.weights])[0].why_on_ground()
    ):
        sentences.append(f"The best run {reason}.")
    if trained.table.empty:  # a search, in which nothing is learned
        return sentences
    runs = read_curves([trained.folder], FITNESS).groupby("seed")[FITNESS]
    gain = max(float(run.max() - run.iloc[0]) for _, run in runs)
    if gain <= tolerance:
        cure = "a larger --population; more --generations."
        sentences.append(
            f"Nothing was learned: no run gained more than {gain:.3g}. Try in this order: "
            "tegotae wiring baseline, which shows whether feedback matters there at all; larger "
            "pushes in the wiring; another --omega; "
            + ("more --episodes." if trained.unit == AgentLearner.UNIT else cure)
        )
    return sentences
