"""`tegotae train`: learn controllers of one model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from tegotae.cli.tables import print_rows
from tegotae.errors import require_count, unknown
from tegotae.extras import require
from tegotae.models import BUDGET, find
from tegotae.rollout import Timing
from tegotae.training.algorithms import ALGORITHMS
from tegotae.training.fitness import EPISODE
from tegotae.training.run import Run, train


@dataclass(frozen=True)
class Train:
    """Train a model's controllers, one per seed; run it again on the same folder to go on."""

    model: Annotated[str, tyro.conf.Positional]
    """The model's name (see `tegotae models`), or an architecture such as ART."""
    out: Annotated[Path | None, tyro.conf.arg(help_behavior_hint="(default: runs/MODEL)")] = None
    """Folder for controllers, curves and checkpoint."""
    seeds: int = 3
    """How many runs from random weights."""
    first_seed: int = 0
    """The first of the seeds."""
    population: Annotated[int | None, tyro.conf.arg(help_behavior_hint="(default: 64)")] = None
    """Episodes per generation and seed."""
    generations: int = 80
    """Generations in all."""
    algorithm: str = "pgpe"
    """How to learn: pgpe, cma-es or openai-es."""
    duration: float = EPISODE.duration_s
    """Length of an episode [s]."""
    tick: float = EPISODE.tick_s
    """Control period [s]."""
    settle: float = 4.0
    """Time in an episode before it is judged [s]."""
    energy: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    budget: int = BUDGET
    """Largest number of trained parameters."""
    tensorboard: bool = False
    """Write TensorBoard logs beside the controllers (extra "tensorboard")."""

    def run(self) -> None:
        """Train, and print how it went."""
        if self.algorithm not in ALGORITHMS:
            raise unknown("algorithm", self.algorithm, ALGORITHMS)
        require_count("seeds", self.seeds)
        require_count("first_seed", self.first_seed, least=0)
        chosen = {} if self.population is None else {"population": self.population}
        run = Run(
            model=find(self.model),
            seeds=tuple(range(self.first_seed, self.first_seed + self.seeds)),
            generations=self.generations,
            algorithm=ALGORITHMS[self.algorithm](**chosen),
            timing=Timing(duration_s=self.duration, tick_s=self.tick),
            settle_s=self.settle,
            energy=self.energy,
            budget=self.budget,
        )
        out = Path("runs") / run.model.name if self.out is None else self.out
        try:
            paths = train(run, out, on_generation=_logger(out) if self.tensorboard else None)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"interrupted; {out} keeps what was learned, the same command goes on from there"
            ) from None
        _summarise(paths)


def _logger(out: Path) -> Callable:
    """A function that logs a generation's curves for TensorBoard, into a folder made by then.

    Raises:
        TegotaeError: at once, if tensorboardX is not installed.
    """
    tensorboard = require("tensorboardX", "tensorboard")

    @cache
    def writer():
        return tensorboard.SummaryWriter(str(out / "tensorboard"))

    def log(generation: int, curves) -> None:
        for name, values in curves._asdict().items():
            writer().add_scalar(name, float(np.mean(values)), generation)
        writer().flush()

    return log


def _summarise(paths: list[Path]) -> None:
    from tegotae.controller_file import load

    found = [(path, load(path).training) for path in paths]
    print_rows(
        ("controller", "fitness", "best generation", "generations"),
        (
            (
                str(path),
                f"{training['best_fitness']:.4f}",
                str(training["best_generation"]),
                str(training["generations"]),
            )
            for path, training in found
        ),
    )
