"""`tegotae generalise`: trained controllers, unchanged, in conditions that they never met."""

from __future__ import annotations

import fnmatch
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from tegotae._support.errors import TegotaeError, require_count
from tegotae.cli.console import print_rows, print_text
from tegotae.cli.figure.output import PictureFormat

if TYPE_CHECKING:
    from tegotae.analysis.generalisation import Disturbance
    from tegotae.analysis.generalisation.run import Done
    from tegotae.analysis.generalisation.trial import Tested


@dataclass(frozen=True, kw_only=True)
class Generalise(PictureFormat):
    """Test trained controllers in conditions outside of their training; run it again on the same
    folder to continue.

    The controllers stay unchanged. MuJoCo models have conditions of their own: mass, gravity,
    friction, frequency, pushes, blows, and delay and noise of the senses.
    """

    places: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Controller files, folders of them, names of pure V models such as V-sector-w4, or a study's
    folder, for all of its records."""
    out: Path = field(default=Path("generalisation"))
    """Folder for records, tables and the picture."""
    conditions: Annotated[tuple[str, ...], tyro.conf.arg(help_behavior_hint="(default: all)")] = ()
    """Conditions by name, such as delay noise, or with your own levels, delay=0.01/0.02; see
    --list."""
    only: str = "*"
    """Test only controllers whose names match this pattern, with * and ? as in a shell."""
    starts: int = 4
    """Number of releases, for several legs or a MuJoCo model with noise."""
    anew: bool = False
    """Start again, and move existing records to a folder beside this one."""
    list: bool = False
    """Print the conditions and their levels, and exit."""

    def run(self) -> None:
        """Try, write, and print."""
        from tegotae.analysis.generalisation import disturbances_named

        names = [name for words in self.conditions for name in words.split(",")]
        chosen = disturbances_named(names)
        if self.list:
            _print_conditions(chosen)
            return
        require_count("starts", self.starts, most=64)
        if not self.places:
            raise TegotaeError("name a controller file, a folder, or a study's folder")
        from tegotae._support.workplace import GENERALISATION, require_free_for
        from tegotae.analysis.generalisation.run import generalise, write_tables
        from tegotae.figures.generalisation import curves_figure
        from tegotae.figures.style import save_figure

        require_free_for(self.out, GENERALISATION)
        done = generalise(self._subjects(), chosen, self.out, anew=self.anew)
        paths = write_tables(done, chosen, self.out)
        paths.append(save_figure(curves_figure(done, chosen), self.out / f"curves.{self.format}"))
        _print_margins(done, chosen)
        print("wrote " + ", ".join(map(str, paths)))

    def _is_chosen(self, name: str) -> bool:
        """Whether a set is asked for, by its model's name or with what differs in its training."""
        model = name.partition(" (")[0]
        return any(fnmatch.fnmatchcase(each, self.only) for each in (name, model))

    def _subjects(self) -> list[Tested]:
        from tegotae.questions.task import tasks_of

        tasks = tasks_of(*self.places)
        chosen = [task for task in tasks if self._is_chosen(task.name)]
        if not chosen:
            names = ", ".join(sorted({task.name for task in tasks})[:3])
            raise TegotaeError(f"no model matches {self.only}; there are {names}")
        return [task.tested(self.starts) for task in chosen]


def _print_conditions(chosen: tuple[Disturbance, ...]) -> None:
    print_rows(
        ("condition", "what", "unit", "none", "levels"),
        (
            (
                each.name,
                each.label,
                each.unit,
                f"{each.neutral:g}",
                "/".join(f"{x:g}" for x in sorted(each.levels)),
            )
            for each in chosen
        ),
    )


def _print_margins(done: list[Done], chosen: tuple[Disturbance, ...]) -> None:
    from tegotae.analysis.generalisation import margins

    rows = [
        (tested.name, found.condition, found.side, *map(_cell, found[2:]))
        for tested, outcome in done
        for found in margins(outcome, chosen)
    ]
    titles = ("controller", "condition", "side", "runs", "survived", "failed", "from", "to")
    print_rows(titles, rows)
    for tested, outcome in done:
        if outcome.left_out:
            print(f"{tested.name} was left out of {json.dumps(outcome.left_out)[1:-1]}")
    print_text(
        "Survived: the last level up to which more than half of the runs keep their undisturbed "
        "gait; failed: the next one tested, inf beyond the last. From, to: 95 % interval over runs."
    )


def _cell(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3g}"
