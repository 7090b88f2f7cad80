"""Compare lengths of training episodes: many short ones against few long ones.

    python -m research.experiments.episode_length

writes `research/experiments/episode_length.csv` and prints it. CoT⁻¹ is meant after limit-cycle
formation, but a training episode judges what follows a fixed time. Both ways spend the same
simulated time.
"""

from __future__ import annotations

import csv
from collections import deque
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from research.frame import main
from tegotae.cli.console import print_rows
from tegotae.measures.evaluation import evaluate
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.statistics import mean_defined
from tegotae.simulation.rollout import Timing
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run

DOCS = Path(__file__).resolve().parents[2] / "docs"
MODELS = (
    *("VG-gF-reflex-w4", "VT-tphif-w4", "AR-rF-sector-w4", "AR-rF-reflex-w4", "ART-rF-tphif-w4"),
    *("ART-rFv-tphif-w4", "AR-rF-reflex-w8", "ART-rF-tphif-w8"),
)
WAYS = ((12.0, 4.0, 64), (24.0, 12.0, 32))
"""Episode [s], of which left to settle [s], and episodes in a generation."""
_STEPS = PGPE(std=0.3, std_lr=0.1, learning_rate=0.2, max_speed=0.4)
"""Larger than by default, as the trainings are short."""
METRICS = ("limit_cycle_share", "cot_inverse", "cot_inverse_total", "t0_s")
COLUMNS = ("model", "episode_s", "settle_s", "population", "share_at_omega_t", *METRICS)


@dataclass(frozen=True)
class EpisodeLength:
    """Train, evaluate, and write the table."""

    seeds: int = 8
    """Trainings of each model."""
    generations: int = 80
    """Generations of PGPE."""
    out: Path = Path(__file__).parent / "episode_length.csv"
    """The table."""

    def run(self) -> None:
        """Run the whole study."""
        rows = [self._row(model, *setting) for model in MODELS for setting in WAYS]
        with self.out.open("w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream, lineterminator="\n")
            table.writerow(COLUMNS)
            table.writerows(rows)
        print_rows(COLUMNS, rows)

    def _row(self, name: str, episode_s: float, settle_s: float, population: int) -> list[str]:
        run = Run(
            experiment=recipe(name).experiment(
                timing=Timing(duration_s=episode_s, tick_s=0.002),
                objective=Fitness(settle_s=settle_s),
            ),
            seeds=tuple(range(self.seeds)),
            learner=Evolution(
                algorithm=replace(_STEPS, population=population),
                stopping=Stopping.after(self.generations),
            ),
        )
        experiment, protocol = run.experiment, run.experiment.protocol
        ((progress, _),) = deque(
            run.learner.evolve(run.experiment, run.seeds),
            maxlen=1,
        )
        weights = np.asarray(progress.best_weights)
        results = evaluate(
            experiment.controller, weights, experiment.omega, experiment.body, protocol
        ).episodes
        at_omega_t = results["limit_cycle_share"][:, protocol.offsets.index(0.0)]
        means = [at_omega_t.mean(), *(mean_defined(results[metric].ravel()) for metric in METRICS)]
        return [name, f"{episode_s:g}", f"{settle_s:g}", f"{population}"] + [
            f"{float(mean):.3f}" for mean in means
        ]


if __name__ == "__main__":
    main(EpisodeLength)
