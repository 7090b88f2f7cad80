"""Measure the gain from learned feedback on bodies with legs: train, evaluate, keep, report.

    python -m research.learned_legs.run train     # what is missing; about an hour of a core
    python -m research.learned_legs.run train --only 'AR*+range@*'
    python -m research.learned_legs.run evaluate  # by releases that no training met
    python -m research.learned_legs.run zoo       # the laws for a range, by name
    python -m research.learned_legs.run report    # tables and figures of the page

Controllers are kept in `runs/learned_legs`, a folder each; tables and figures go to
`research/learned_legs`. A training goes on where it was interrupted. What is trained is in
`learned_legs_plan.py`.
"""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass
from pathlib import Path

from research.frame import main
from research.learned_legs import evaluate as evaluation, report, zoo
from research.learned_legs.plan import CELLS, FOLDER, Cell, is_trained
from tegotae.training.run import train


@dataclass(frozen=True)
class Train:
    """Train what is missing."""

    only: str = "*"
    """Cells to process, a name with * and ? as in a shell."""
    dir: Path = FOLDER
    """Folder of the controllers."""

    def run(self) -> None:
        """Train them."""
        for cell in matching(self.only):
            if not is_trained(cell, self.dir):
                train(cell.run, self.dir / cell.name)


@dataclass(frozen=True)
class Evaluate:
    """Evaluate what has been trained: from random phases, at several frequencies."""

    only: str = "*"
    dir: Path = FOLDER

    def run(self) -> None:
        """Evaluate, and write the tables."""
        evaluation.evaluate_all(trained(self.only, self.dir), self.dir)


@dataclass(frozen=True)
class Zoo:
    """Keep the laws that were trained for a range as a study of the zoo."""

    dir: Path = FOLDER

    def run(self) -> None:
        """Write the file; all of them have to be evaluated."""
        zoo.write_zoo([cell for cell in trained("*+range@*", self.dir) if cell.ranged], self.dir)


@dataclass(frozen=True)
class Report:
    """Tables in Markdown, and figures."""

    def run(self) -> None:
        """Write the tables and figures."""
        report.report()


def matching(pattern: str) -> list[Cell]:
    """Return the cells of a name."""
    return [cell for cell in CELLS if fnmatch.fnmatchcase(cell.name, pattern)]


def trained(pattern: str, folder: Path) -> list[Cell]:
    """Return the matching cells that are trained to the end."""
    return [cell for cell in matching(pattern) if is_trained(cell, folder)]


if __name__ == "__main__":
    main(Train, Evaluate, Zoo, Report)
