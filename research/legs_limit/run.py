"""The least cost of transport over speed of quadruped C, as far as a search finds it.

    python -m research.legs_limit.run search   # missing stages; a few CPU-minutes
    python -m research.legs_limit.run further  # from the kept gaits on, larger spaces
    python -m research.legs_limit.run report   # tables and figures of present stages

Thousands of gaits without feedback are rolled out on the same body as controllers have, and
evolution strategies make them cheaper. A stage is a file in `runs/legs_limit`; a search goes on
with the next one that is missing. `report` keeps the best gait of every speed, simulated again with
a shorter tick and for longer: the kept table (`legs_limit_known.py`), and tables and
figures of `docs/studies/legs_limit.md`. A kept gait stays until a cheaper one is found.

A small search of all stages, written elsewhere:

    python -m research.legs_limit.run search --speeds 0.4 1 --share 0.02 --dir runs/small
    python -m research.legs_limit.run report --dir runs/small --out runs/small/report
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from research.frame import main
from research.legs_limit import report as legs_limit_report, strategies
from research.legs_limit.gaits import Space
from research.legs_limit.search import POPULATION, kept_gaits, losses
from research.legs_limit.strategies import Found
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder

FOLDER = Path("runs/legs_limit")
SPEEDS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)
"""Speeds that are looked at [√(g l0)]."""


@dataclass(frozen=True)
class Stage:
    """Search at every speed.

    Args:
        space: what gaits there are.
        sources: stages whose best gaits it starts from, at the same speed and its neighbours, or
            `kept`; random starts if there are none.
        starts: how many at every speed.
        generations: how many.
        std: first deviation.
    """

    space: Space
    sources: tuple[str, ...] = ()
    starts: int = 2
    generations: int = 240
    std: float = 0.3
    note: str = ""

    @property
    def name(self) -> str:
        """Return the name of the stage's file."""
        return self.space.name + self.note

    @property
    def feet(self) -> str:
        """Return the kind of motion that the feet are free to have."""
        return self.space.feet

    def begin(
        self, folder: Path, seed: int, speeds: tuple[float, ...]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return speeds and vectors to start from, [starts] and [starts, size]."""
        targets = np.repeat(speeds, self.starts)
        if not self.sources:
            rng = np.random.default_rng(seed)
            return targets, np.array([self.space.random(rng) for _ in targets])
        sources = []
        for name in self.sources:
            if name == KEPT:
                sources += [
                    (*gait, losses(gait[0], *gait[:0:-1])[0]) for gait in kept_gaits(self.feet)
                ]
            else:
                space, (of_speed, result) = STAGES[name].space, load(folder, name)
                sources.append((space, of_speed, result.x, losses(space, result.x, of_speed)[0]))
        vectors = []
        for number, speed in enumerate(targets):
            rank = number % self.starts
            candidates = [
                (
                    loss + abs(np.log(origin / speed)) * (origin != speed),
                    self.space.from_space(space, x),
                )
                for space, of_speed, vectors_known, loss_known in sources
                for origin, x, loss in zip(of_speed, vectors_known, loss_known, strict=True)
            ]
            best = sorted(range(len(candidates)), key=lambda k: candidates[k][0])
            vectors.append(candidates[best[rank % len(best)]][1])
        return targets, np.array(vectors)


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
KEPT = "kept"
"""Name of the kept gaits in place of a stage's name."""
_FURTHER = tuple(
    Stage(Space(feet, steps, harmonics), (KEPT,), std=0.03, generations=400, note="-f")
    for feet in ("ellipse", "free")
    for steps, harmonics in ((1, 3), (1, 5), (2, 3), (4, 3))
)
FURTHER_SPEEDS = (0.3, 0.8, 1.6)
"""Speeds at which larger spaces are searched from the kept gaits on."""
STAGES = {stage.name: stage for stage in (*_ALL, *_FURTHER)}


def load(folder: Path, name: str) -> tuple[np.ndarray, Found]:
    """Return the speeds and the best of every start of a stage."""
    with np.load(folder / f"{name}.speeds.npz") as record:
        return record["speed"], strategies.load(folder / f"{name}.npz")


@dataclass(frozen=True)
class Search:
    """Search what is missing, from random starts."""

    only: tuple[str, ...] = ()
    """Stages; all by default."""
    dir: Path = FOLDER
    speeds: tuple[float, ...] = SPEEDS
    """Speeds that are looked at."""
    share: float = 1.0
    """Share of the generations of each stage."""
    seed: int = 0

    def run(self) -> None:
        """Search, stage by stage."""
        run_stages(tuple(stage.name for stage in _ALL), self)


@dataclass(frozen=True)
class Further(Search):
    """Search from the kept gaits on: more harmonics and steps, and the same ones as a control."""

    speeds: tuple[float, ...] = FURTHER_SPEEDS
    """Speeds that are looked at."""

    def run(self) -> None:
        """Search, stage by stage."""
        run_stages(tuple(stage.name for stage in _FURTHER), self)


def run_stages(names: tuple[str, ...], search: Search) -> None:
    """Search the stages of these names that are missing or not at their end."""
    for name in search.only:
        if name not in names:
            raise TegotaeError(f"there is no stage {name}; there are {', '.join(names)}")
    output_folder(search.dir)
    for number, name in enumerate(names):
        stage, file = STAGES[name], search.dir / f"{name}.npz"
        generations = max(round(search.share * stage.generations), 1)
        if search.only and name not in search.only:
            continue
        if file.exists() and len(strategies.load(file).history) >= generations:
            continue
        seed = search.seed + number
        targets, start = stage.begin(search.dir, seed, search.speeds)
        np.savez(search.dir / f"{name}.speeds.npz", speed=targets)
        lanes = np.repeat(targets, POPULATION)

        def loss_of(x: np.ndarray, _: int, space=stage.space, lanes=lanes) -> np.ndarray:
            return losses(space, x, lanes)[0]

        def report(generation: int, loss: np.ndarray, stage=stage, total=generations) -> None:
            if generation % 20 == 0 or generation == total:
                costs = np.exp(loss.reshape(-1, stage.starts).min(axis=1))
                print(f"{stage.name} {generation}/{total}:", *np.round(costs, 3), flush=True)

        strategies.search(
            loss_of,
            start,
            std=stage.std,
            population=POPULATION,
            generations=generations,
            seed=seed,
            checkpoint=file,
            progress=report,
        )


@dataclass(frozen=True)
class Report:
    """Write the kept limit, tables and figures."""

    dir: Path = FOLDER
    out: Path | None = None
    """Folder for a report of these stages alone, without what is kept."""

    def run(self) -> None:
        """Report the stages whose files exist."""
        present = [name for name in STAGES if (self.dir / f"{name}.npz").exists()]
        legs_limit_report.report(
            {name: (STAGES[name].space, *load(self.dir, name)) for name in present}, self.out
        )


if __name__ == "__main__":
    main(Search, Further, Report)
