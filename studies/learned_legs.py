"""What bodies with legs gain from learned feedback: train, evaluate, disturb, report.

    python studies/learned_legs.py train             # what is missing; about an hour of a core
    python studies/learned_legs.py train --only 'AR*@quadruped-c'
    python studies/learned_legs.py evaluate          # from random phases, over frequencies
    python studies/learned_legs.py disturb           # mass, slope, pushes, a lost leg, ...
    python studies/learned_legs.py vanilla           # vanilla feedback over σ and ω
    python studies/learned_legs.py report            # tables and figures of the page

Controllers are kept in `runs/learned_legs`, a folder each; tables and figures go to
`docs/_static/learned_legs`. A training goes on where it was interrupted. What is trained is in
`learned_legs_plan.py`.
"""

from __future__ import annotations

import fnmatch
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

import learned_legs_disturb as disturbances
import learned_legs_evaluate as evaluation
import learned_legs_report as report
import learned_legs_vanilla as vanilla
from learned_legs_plan import CELLS, FOLDER, Cell, is_trained
from tegotae.cli.status import exit_status
from tegotae.training.run import train


@dataclass(frozen=True)
class Train:
    """Train what is missing."""

    only: str = "*"
    """Which cells, a name with * and ? as in a shell."""
    dir: Path = FOLDER
    """Folder of the controllers."""

    def run(self) -> None:
        """Train them."""
        for cell in chosen(self.only):
            if not is_trained(cell, self.dir):
                train(cell.run, self.dir / cell.name)


@dataclass(frozen=True)
class EvaluateAll:
    """Evaluate what has been trained: from random phases, at several frequencies."""

    only: str = "*"
    dir: Path = FOLDER

    def run(self) -> None:
        """Evaluate, and write the table."""
        evaluation.evaluate_all([c for c in chosen(self.only) if is_trained(c, self.dir)], self.dir)


@dataclass(frozen=True)
class Disturb:
    """Put what has been trained where it never was."""

    only: str = "*"
    dir: Path = FOLDER

    def run(self) -> None:
        """Disturb, and write the table."""
        cells = [c for c in chosen(self.only) if is_trained(c, self.dir)]
        disturbances.disturb_all(cells, self.dir)


@dataclass(frozen=True)
class Vanilla:
    """Vanilla feedback over gain and frequency, and forced trots: what they cost at a speed."""

    def run(self) -> None:
        """Sweep, and write the tables."""
        vanilla.sweep()


@dataclass(frozen=True)
class Report:
    """Tables in Markdown, and figures."""

    dir: Path = FOLDER

    def run(self) -> None:
        """Write them."""
        report.report(self.dir)


def chosen(pattern: str) -> list[Cell]:
    """The cells of that name."""
    return [cell for cell in CELLS if fnmatch.fnmatchcase(cell.name, pattern)]


if __name__ == "__main__":
    command = tyro.cli(
        Annotated[Train, tyro.conf.subcommand("train")]
        | Annotated[EvaluateAll, tyro.conf.subcommand("evaluate")]
        | Annotated[Disturb, tyro.conf.subcommand("disturb")]
        | Annotated[Vanilla, tyro.conf.subcommand("vanilla")]
        | Annotated[Report, tyro.conf.subcommand("report")]
    )
    sys.exit(exit_status(command.run))
