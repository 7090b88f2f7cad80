"""Train the paper's architectures, compare them, and draw what came out: `make reproduce`.

Writes controllers, `comparison.csv` and figures to a folder, and goes on where it stopped.
"""

from __future__ import annotations

import csv
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console

from tegotae import controller_file
from tegotae.cli.evaluate import evaluate_all, print_table, show
from tegotae.cli.tables import print_rows
from tegotae.collection import Runs, read
from tegotae.evaluation import Evaluation, Protocol
from tegotae.figures.animation import write_animation
from tegotae.figures.comparison import comparison_figure, learning_curves_figure
from tegotae.figures.rollout import rollout_figure
from tegotae.figures.style import save_figure
from tegotae.files import output_folder, write_atomically
from tegotae.metrics.statistics import Interval
from tegotae.models import find
from tegotae.rollout import Scenario, Timing
from tegotae.simulation import Result, Simulation
from tegotae.study.claims import verdicts
from tegotae.study.table import of_runs
from tegotae.training.run import Run, train

ARCHITECTURES = (
    "V-sector",
    "V-reflex",
    "VT-tphif",
    "VG-gF-reflex",
    "VG-gFv-reflex",
    "AR-rF-reflex",
    "AR-rFv-reflex",
    "ART-rF-tphif",
    "ART-rFv-tphif",
    "ARG-rF-gF-reflex",
    "ARG-rFv-gFv-reflex",
    "ARGT-rF-gF-tphif",
    "ARGT-rFv-gFv-tphif",
)
MODELS = (*(f"{name}-w{omega}" for omega in (4, 8) for name in ARCHITECTURES), "T-F", "T-Fv")
"""Each architecture on [F_k] and [F_k, ẏ], at both frequencies; reflex or learned actuation."""

PANELS = {
    "cot_inverse": "CoT⁻¹ [m/J]",
    "t0_s": "T0 [s]",
    "t1_s": "T1 [s]",
    "cpgu": "CPGu",
    "limit_cycle_share": "limit cycles",
}


@dataclass(frozen=True)
class Reproduce:
    """Train and compare the paper's architectures."""

    out: Path = Path("results")
    """Folder for controllers, tables and figures."""
    seeds: int = 5
    """Runs per model."""
    generations: int = 80
    """Generations of PGPE."""

    def run(self) -> None:
        """Do it all."""
        begun = time.monotonic()
        console = Console(soft_wrap=True, highlight=False)
        output_folder(self.out)
        curves = {}
        for name in MODELS:
            run = Run(
                model=find(name), seeds=tuple(range(self.seeds)), generations=self.generations
            )
            train(run, self.out / "controllers" / name)
            if run.model.is_trained:
                curves[name] = _curves(self.out / "controllers" / name / "curves.csv")
        sets = [runs for name in MODELS for runs in read(self.out / "controllers" / name)]
        found = evaluate_all(sets, Protocol())
        console.print(f"\n{self.seeds} runs per model, {self.generations} generations of PGPE:")
        print_table(found)
        _print_claims(found)
        self._write_table([(runs.name, evaluation) for runs, evaluation in found])
        self._draw([(runs.name, evaluation) for runs, evaluation in found], curves)
        minutes = (time.monotonic() - begun) / 60.0
        console.print(f"\nTable and figures are in {self.out.resolve()} ({minutes:.1f} min)")

    def _write_table(self, found: list[tuple[str, Evaluation]]) -> None:
        rows = [",".join(("model", "metric", "mean", "low", "high", "runs", "undefined"))]
        for name, evaluation in found:
            for metric, i in evaluation.summary().items():
                numbers = ",".join(
                    "" if np.isnan(x) else f"{x:.6g}" for x in (i.mean, i.low, i.high)
                )
                rows.append(f"{name},{metric},{numbers},{i.count},{i.undefined}")
        write_atomically(self.out / "comparison.csv", "\n".join(rows) + "\n")

    def _draw(self, found: list[tuple[str, Evaluation]], curves: dict[str, np.ndarray]) -> None:
        def triple(i: Interval) -> tuple[float, float, float]:
            return i.mean, *((i.mean, i.mean) if np.isnan(i.low) else (i.low, i.high))

        summaries = [evaluation.summary() for _, evaluation in found]
        panels = {
            label: [triple(summary[metric]) for summary in summaries]
            for metric, label in PANELS.items()
        }
        save_figure(
            comparison_figure([name for name, _ in found], panels), self.out / "comparison.png"
        )
        save_figure(
            learning_curves_figure(curves, "CoT⁻¹ of the distribution's mean [m/J]"),
            self.out / "learning_curves.png",
        )
        best = _best_hop(self.out / "controllers" / "ART-rF-tphif-w4")
        save_figure(rollout_figure(best), self.out / "best_art.png")
        write_animation(best, self.out / "best_art.gif")


def _print_claims(found: list[tuple[Runs, Evaluation]]) -> None:
    """What these few runs say about the paper's claims."""
    table = of_runs(
        (runs.name, np.full(evaluation.n_runs, np.nan), evaluation.runs())
        for runs, evaluation in found
    )
    rows = []
    for verdict in verdicts(table):
        for i, part in enumerate(verdict.parts):
            claim = (f"{verdict.number}", verdict.verdict) if i == 0 else ("", "")
            rows.append((*claim, part.what, show(part.effect), part.verdict))
    print_rows(("claim", "verdict", "effect", "mean [95 % interval]", "part"), rows)


def _curves(path: Path) -> np.ndarray:
    """CoT⁻¹ of the distribution's mean [m/J], shape [generations, seeds]."""
    with path.open() as stream:
        rows = list(csv.DictReader(stream))
    seeds = len({row["seed"] for row in rows})
    return np.array([float(row["centre_cot_inverse"]) for row in rows]).reshape(-1, seeds)


def _best_hop(folder: Path) -> Result:
    """A rollout of the fittest controller in a folder."""
    saved = max(
        (controller_file.load(path) for path in folder.glob("*-seed*.json")),
        key=lambda saved: saved.training["best_fitness"],
    )
    timing = Timing(duration_s=10.0, frame_s=0.01)
    return Simulation(
        saved.controller, saved.weights, Scenario(omega=saved.omega), timing=timing
    ).run()


if __name__ == "__main__":
    tyro.cli(Reproduce).run()
