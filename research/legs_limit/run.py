"""Search the gaits of least cost of transport of quadruped C, speed by speed.

    python -m research.legs_limit.run search     # stage by stage; about ten minutes of a core
    python -m research.legs_limit.run report     # table and figure of the page

Stages are kept in `runs/legs_limit`, and go on where they were interrupted. The report simulates
the cheapest gait of every speed again, with a shorter tick and for longer: the kept table
(`known.csv`) and the page's. A kept gait (`gaits.json`) stays until a cheaper one is found.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from research.frame import main
from research.legs_limit import report as legs_limit_report, strategies
from research.legs_limit.gaits import Space
from research.legs_limit.search import POPULATION, losses
from tegotae._support.files import output_folder

FOLDER = Path("runs/legs_limit")
SPEEDS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)
"""Speeds that are looked at [√(g l0)]."""


@dataclass(frozen=True)
class Stage:
    """Search at every speed.

    Args:
        space: what gaits there are.
        sources: stages whose best gaits it starts from, at the same speed and its neighbours;
            random starts if there are none.
        starts: how many at every speed.
        generations: how many.
        std: first deviation.
    """

    space: Space
    sources: tuple[str, ...] = ()
    starts: int = 2
    generations: int = 240
    std: float = 0.3

    def begin(
        self, folder: Path, seed: int, speeds: tuple[float, ...]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return speeds and vectors to start from, [starts] and [starts, size]."""
        targets = np.repeat(speeds, self.starts)
        if not self.sources:
            rng = np.random.default_rng(seed)
            return targets, np.array([self.space.random(rng) for _ in targets])
        origins, vectors, costs = [], [], []
        for name in self.sources:
            space, x = STAGES[name].space, strategies.load(folder / f"{name}.npz").x
            origins += (of_speed := np.repeat(speeds, STAGES[name].starts)).tolist()
            vectors += [self.space.from_space(space, vector) for vector in x]
            costs += losses(space, x, of_speed)[0].tolist()
        starts = []
        for number, speed in enumerate(targets):
            order = np.argsort(costs + abs(np.log(np.array(origins) / speed)))
            starts.append(vectors[order[number % self.starts]])
        return targets, np.array(starts)


AGAIN = {"std": 0.1, "generations": 500}
NEAR = {"std": 0.03, "generations": 500}
FREE, BOUND = Space("free"), Space("ellipse")
STAGES = {
    "ellipse": Stage(BOUND, generations=120),
    "free": Stage(FREE),
    "ellipse-b": Stage(BOUND, ("ellipse",), std=0.1),
    "free-b": Stage(FREE, ("ellipse-b", "free"), **AGAIN),
    "ellipse-c": Stage(BOUND, ("ellipse-b",), **NEAR),
    "free-c": Stage(FREE, ("free-b",), **AGAIN),
    "free-d": Stage(FREE, ("free-b", "free-c"), **NEAR),
    "ellipse-d": Stage(BOUND, ("ellipse-b", "ellipse-c"), starts=4, generations=300, std=0.1),
    "ellipse-e": Stage(BOUND, ("ellipse-d",), std=0.05),
    "ellipse-f": Stage(Space("ellipse", 5), ("ellipse-e",), **NEAR),
    "free-f": Stage(Space("free", 5), ("free-d",), **NEAR),
}
"""Stages by name; the last ones have five harmonics."""


def search(
    dir: Path = FOLDER, speeds: tuple[float, ...] = SPEEDS, share: float = 1.0, seed: int = 0
) -> None:
    """Search the stages that are missing or not at their end.

    Args:
        dir: folder of the stages.
        speeds: speeds that are looked at.
        share: share of the generations of each stage.
        seed: of the draws.
    """
    output_folder(dir)
    for number, (name, stage) in enumerate(STAGES.items()):
        file, generations = dir / f"{name}.npz", max(round(share * stage.generations), 1)
        if file.exists() and len(strategies.load(file).history) >= generations:
            continue
        targets, start = stage.begin(dir, seed + number, speeds)
        lanes = np.repeat(targets, POPULATION)
        strategies.search(
            lambda x, _, stage=stage, lanes=lanes: losses(stage.space, x, lanes)[0],
            start,
            std=stage.std,
            population=POPULATION,
            generations=generations,
            seed=seed + number,
            checkpoint=file,
        )
        print(name, flush=True)


def report(dir: Path = FOLDER, speeds: tuple[float, ...] = SPEEDS) -> None:
    """Write the kept limit, its table and its figure, from the kept gaits and all stages there are.

    Args:
        dir: folder of the stages.
        speeds: speeds at which they were searched.
    """
    legs_limit_report.report(
        {
            name: (stage.space, np.repeat(speeds, stage.starts), strategies.load(file))
            for name, stage in STAGES.items()
            if (file := dir / f"{name}.npz").exists()
        }
    )


if __name__ == "__main__":
    main(search, report)
