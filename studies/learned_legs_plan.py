"""What the study of learned feedback on legs trains, and for how long: fixed before any result."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tegotae.simulation.world import OneOf
from tegotae.systems.designs import Design, design
from tegotae.systems.experiment import Experiment
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run
from tegotae.training.settings import tuned
from tegotae.training.stopping import Stopping

FOLDER = Path("runs/learned_legs")
"""Where controllers are kept."""
TABLES = Path(__file__).resolve().parents[1] / "docs" / "_static" / "learned_legs"
"""Where tables and figures go."""


@dataclass(frozen=True)
class Cell:
    """A design that is trained from several seeds, all cells of a body for as long."""

    of: str
    """The design's name."""
    generations: int = 100
    """Exactly so many, of 32 episodes each."""
    seeds: int = 5
    """Runs from random weights."""
    loses_legs: bool = False
    """Whether each leg in turn is missing in its episodes."""
    deviation: float = 0.1
    """First deviation of the search; what began with 0.2 was trained before 0.1 was chosen."""
    note: str = ""
    """What is added to its name, if it is not trained as others of the design are."""

    @cached_property
    def design(self) -> Design:
        """The design."""
        return design(self.of)

    @property
    def name(self) -> str:
        """The design's name, with `+lost` before the @ if legs are lost in training, or a note."""
        return self.experiment.name

    @cached_property
    def experiment(self) -> Experiment:
        """What is trained."""
        found = self.design.experiment()
        if self.note:
            found = dataclasses.replace(found, name=found.name.replace("@", f"+{self.note}@"))
        if not self.loses_legs:
            return found
        limbs = found.body.limbs
        there = [tuple(float(leg != lost) for leg in range(limbs)) for lost in range(-1, limbs)]
        return dataclasses.replace(
            found,
            name=found.name.replace("@", "+lost@"),
            conditions=(OneOf("present", values=tuple(there)),),
            episodes=len(there),
        )

    @property
    def run(self) -> Run:
        """How it is trained."""
        return Run(
            experiment=self.experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(
                algorithm=dataclasses.replace(tuned("pgpe"), std=self.deviation),
                stopping=Stopping.after(self.generations),
            ),
        )


ADDED = "ART-t+phif"
"""T is added to the ellipse."""
QUADRUPED = tuple(
    Cell(f"{family}@quadruped-c")
    for family in (
        *("V", "cos", "VG", "AR", "ARG", ADDED, "ARGT-t+phif", "ART"),
        *("T-F", "W-Fa", "Wphi-F"),
    )
)
SPEEDS = tuple(
    Cell(f"{family}-w{omega}@quadruped-c", seeds=3, deviation=0.2)
    for omega in (1, 3)
    for family in ("V", "AR")
)
LOST = (Cell("AR@quadruped-c", generations=60, seeds=3, loses_legs=True, deviation=0.2),)
PLATE = tuple(
    Cell(f"{family}@plate-light-pitch", seeds=4, deviation=0.2)
    for family in ("V", "AR", "ART", "Wphi-F")
)
HEXAPOD = tuple(Cell(f"{family}@hexapod", seeds=3) for family in ("V", "AR"))
LONG = tuple(
    Cell(f"{family}@quadruped-c", generations=300, note="long")
    for family in ("VG", "AR", "ARG", ADDED, "Wphi-F")
)
"""Whether what came out after 100 generations is what comes out."""
WIDE = tuple(
    Cell(f"{family}@quadruped-c", deviation=0.2, note="wide")
    for family in ("VG", "AR", "ARG", ADDED)
)
"""Whether the search decides."""
CELLS = (*QUADRUPED, *SPEEDS, *LOST, *PLATE, *HEXAPOD, *LONG, *WIDE)
"""All, in the order in which they are trained."""


def is_trained(cell: Cell, folder: Path) -> bool:
    """Whether a cell has all its controllers, trained to the end."""
    from tegotae.systems.controller_file import load

    searched = cell.experiment.is_searched
    files = sorted((folder / cell.name).glob("*-seed*.json"))
    if len(files) < (1 if searched else cell.seeds):
        return False
    return all(load(file).training["ended"] for file in files)
