"""The least cost of transport over speed of quadruped C, as far as a search finds it.

    python studies/legs_limit.py search     # what is missing, stage by stage; a few CPU-minutes
    python studies/legs_limit.py report     # tables and figures from the stages that are there

Thousands of gaits without feedback are rolled out on the same body as controllers have, and
evolution strategies make them cheaper. A stage is a file in `runs/legs_limit`; a search goes on
with the next one that is missing. `report` keeps the best gait of every speed, simulated again with
a shorter tick and for longer: the package's table (`tegotae.measures.gaits.limit`), and tables and
figures of `docs/studies/legs_limit.md`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

import legs_limit_report
from legs_limit_gaits import Space
from legs_limit_search import Found, losses, search
from tegotae._support.files import output_folder
from tegotae.cli.status import exit_status

FOLDER = Path("runs/legs_limit")
SPEEDS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)
"""Speeds that are looked at [√(g l0)]."""


@dataclass(frozen=True)
class Stage:
    """One search at every speed.

    Args:
        space: what gaits there are.
        after: stages whose best gaits it starts from, at the same speed and its neighbours; random
            starts if there are none.
        starts: how many at every speed.
        generations: how many.
        std: first deviation.
    """

    space: Space
    after: tuple[str, ...] = ()
    starts: int = 2
    generations: int = 240
    std: float = 0.3
    note: str = ""

    @property
    def name(self) -> str:
        """Of its file."""
        return self.space.name + self.note

    def begin(self, folder: Path, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Speeds and vectors to start from, [starts] and [starts, size]."""
        speeds = np.repeat(SPEEDS, self.starts)
        if not self.after:
            rng = np.random.default_rng(seed)
            return speeds, np.array([self.space.random(rng) for _ in speeds])
        known = []
        for name in self.after:
            space, (of_speed, found) = STAGES[name].space, load(folder, name)
            known.append((space, of_speed, found.x, losses(space, found.x, of_speed)[0]))
        vectors = []
        for number, speed in enumerate(speeds):
            rank = number % self.starts
            each = [
                (
                    loss + abs(np.log(of / speed)) * (of != speed),
                    self.space.from_space(space, x),
                )
                for space, of_speed, vectors_known, loss_known in known
                for of, x, loss in zip(of_speed, vectors_known, loss_known, strict=True)
            ]
            best = sorted(range(len(each)), key=lambda k: each[k][0])
            vectors.append(each[best[rank]][1])
        return speeds, np.array(vectors)


FREE, BOUND = Space("free", 1, 3), Space("ellipse", 1, 3)
AGAIN = {"std": 0.1, "generations": 500}
NEAR = {"std": 0.03, "generations": 500}
_ALL = (
    Stage(BOUND, generations=120),
    Stage(FREE),
    Stage(BOUND, ("ellipse-1-3",), std=0.1, note="-b"),
    Stage(FREE, ("ellipse-1-3-b", "free-1-3"), **AGAIN, note="-b"),
    Stage(BOUND, ("ellipse-1-3-b",), **NEAR, note="-c"),
    Stage(FREE, ("free-1-3-b",), **AGAIN, note="-c"),
    Stage(FREE, ("free-1-3-b", "free-1-3-c"), **NEAR, note="-d"),
    Stage(BOUND, ("ellipse-1-3-b", "ellipse-1-3-c"), starts=4, generations=300, std=0.1, note="-d"),
    Stage(BOUND, ("ellipse-1-3-d",), std=0.05, note="-e"),
    Stage(Space("ellipse", 1, 5), ("ellipse-1-3-e",), **NEAR),
    Stage(Space("free", 1, 5), ("free-1-3-d",), **NEAR),
    Stage(Space("ellipse", 2, 3), ("ellipse-1-3-e",), **NEAR),
    Stage(Space("free", 2, 3), ("free-1-3-d",), **NEAR),
    Stage(Space("ellipse", 4, 3), ("ellipse-1-3-e",), **NEAR),
    Stage(Space("free", 4, 3), ("free-1-3-d",), **NEAR),
    Stage(Space("ellipse", 1, 1), ("ellipse-1-3-e",), std=0.1, generations=120),
    Stage(Space("free", 1, 1), ("free-1-3-d",), std=0.1, generations=240),
    Stage(Space("free", 1, 5), ("free-1-5", "free-1-3-d"), **NEAR, note="-b"),
)
STAGES = {stage.name: stage for stage in _ALL}


def load(folder: Path, name: str) -> tuple[np.ndarray, Found]:
    """Speeds and the best of every start of a stage."""
    with np.load(folder / f"{name}.npz") as kept:
        return kept["speed_wanted"], Found(*(kept[field] for field in Found._fields))


@dataclass(frozen=True)
class Search:
    """Search what is missing."""

    only: tuple[str, ...] = ()
    """Stages; all by default."""
    dir: Path = FOLDER
    seed: int = 0

    def run(self) -> None:
        """Search, stage by stage."""
        output_folder(self.dir)
        for number, (name, stage) in enumerate(STAGES.items()):
            file = self.dir / f"{name}.npz"
            if self.only and name not in self.only:
                continue
            if file.exists() and len(load(self.dir, name)[1].history) >= stage.generations:
                continue
            speeds, start = stage.begin(self.dir, self.seed + number)

            def report(generation: int, loss: np.ndarray, name=name, stage=stage) -> None:
                if generation % 20 == 0:
                    least = np.exp(loss.reshape(-1, stage.starts).min(axis=1))
                    print(
                        f"{name} {generation}/{stage.generations}:", *np.round(least, 3), flush=True
                    )

            search(
                stage.space,
                speeds,
                start,
                std=stage.std,
                generations=stage.generations,
                seed=self.seed + number,
                checkpoint=file,
                progress=report,
            )


@dataclass(frozen=True)
class Report:
    """Write the kept limit, tables and figures."""

    dir: Path = FOLDER

    def run(self) -> None:
        """Of the stages that are there."""
        there = [name for name in STAGES if (self.dir / f"{name}.npz").exists()]
        legs_limit_report.report(
            {name: (STAGES[name].space, *load(self.dir, name)) for name in there}
        )


if __name__ == "__main__":
    command = tyro.cli(
        Annotated[Search, tyro.conf.subcommand("search")]
        | Annotated[Report, tyro.conf.subcommand("report")]
    )
    sys.exit(exit_status(command.run))
