"""Trained controllers, unchanged, in conditions outside of their training."""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.tables import write_csv
from tegotae._support.workplace import GENERALISATION, require_free_for
from tegotae.analysis.generalisation import run
from tegotae.analysis.generalisation.disturbances import Disturbance, disturbances_named
from tegotae.questions.answer import AnswerBase, TableAnswer, short
from tegotae.questions.question import question
from tegotae.questions.task import Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class GeneralisationOptions:
    """Which conditions are tried, and where the records are.

    MuJoCo models have conditions of their own: mass, gravity, friction, frequency, pushes, blows,
    and delay and noise of the senses.
    """

    conditions: tuple[str, ...] = ()
    """Conditions by name, such as delay noise, or with your own levels, delay=0.01/0.02; all by
    default."""
    list: bool = False
    """List the conditions and their levels, and test nothing."""
    only: str = "*"
    """Test only controllers whose names match this pattern, with * and ? as in a shell."""
    starts: int = 4
    """Number of releases, for several legs or a MuJoCo model with noise."""
    out: Path = Path("generalisation")
    """Folder for records, tables and the picture; the same one again continues."""
    anew: bool = False
    """Start again, and move existing records to a folder beside this one."""

    @property
    def chosen(self) -> tuple[Disturbance, ...]:
        """The conditions."""
        return disturbances_named([name for x in self.conditions for name in x.split(",")])


@dataclass(frozen=True, repr=False, kw_only=True)
class DisturbanceList(TableAnswer):
    """The conditions that there are."""

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Nothing: nothing was tested."""
        return []


def _conditions(chosen: Sequence[Disturbance]) -> DisturbanceList:
    """The conditions, a row each."""
    rows = [(x.name, x.label, x.unit, f"{x.neutral:g}", _listed(x.levels)) for x in chosen]
    table = pd.DataFrame(rows, columns=["condition", "what", "unit", "none", "levels"])
    shown, data = table.set_index("condition"), {"conditions": table.to_dict("records")}
    return DisturbanceList(table=table, shown=[shown], data=data)


def _listed(levels: Iterable[float]) -> str:
    return "/".join(f"{level:g}" for level in sorted(levels))


@dataclass(frozen=True, repr=False)
class Generalisation(AnswerBase):
    """How much of each condition controllers bear."""

    done: Sequence[run.Done]
    chosen: tuple[Disturbance, ...]

    def frame(self) -> pd.DataFrame:
        """A row a controller, condition and side."""
        return self._margins([""]).drop(columns="measure")

    def texts(self) -> list[pd.DataFrame]:
        frame = self.frame().rename(columns={"low": "from", "high": "to"})
        return [frame.map(short).set_index(["controller", "condition", "side"])]

    @property
    def notes(self) -> list[str]:
        out = [(x.name, y.left_out) for x, y in self.done if y.left_out]
        return [
            *(f"{name} was left out of {json.dumps(why)[1:-1]}" for name, why in out),
            "Survived: the last level up to which more than half of the runs keep their "
            "undisturbed gait; failed: the next one tested, inf beyond the last. From, to: 95 % "
            "interval over runs.",
        ]

    def document(self) -> JsonObject:
        left_out = {tested.name: outcome.left_out for tested, outcome in self.done}
        return as_json({"margins": self.frame().to_dict("records"), "left_out": left_out})

    def figures(self) -> dict[str, Figure]:
        from tegotae.figures.generalisation import curves_figure

        return {"curves": curves_figure(self.done, self.chosen)}

    def _margins(self, measures: Iterable[str]) -> pd.DataFrame:
        rows = [
            (tested.name, measure, *margin)
            for tested, outcome in self.done
            for measure in measures
            for margin in run.margins(outcome, self.chosen, measure)
        ]
        return pd.DataFrame(rows, columns=["controller", "measure", *run.Margin._fields])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Margins by each measure, curves, and what was left out."""
        curves = {tested.name: run.curve(outcome) for tested, outcome in self.done}
        left_out = [
            (tested.name, condition, why)
            for tested, outcome in self.done
            for condition, why in outcome.left_out.items()
        ]
        return {
            "margins": self._margins(run.MEASURES),
            "curves": pd.concat(curves, names=["controller"]).reset_index("controller"),
            "left_out": pd.DataFrame(left_out, columns=["controller", "condition", "why"]),
        }

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Write the tables and the picture into a folder."""
        from tegotae.figures.style import save_figure

        written = []
        for name, table in self.tables().items():
            path = Path(folder) / f"{name}.csv"
            path.unlink(missing_ok=True)  # of another run in this folder
            if len(table):
                write_csv(path, dict(table), digits=4)
                written.append(path)
        written.append(save_figure(self.figures()["curves"], Path(folder) / f"curves.{format}"))
        return written


@question(several=True, nameless=True)
def generalise(tasks: Sequence[Task], options: Sequence[GeneralisationOptions]) -> AnswerBase:
    """Test trained controllers in conditions outside of their training; run it again on the same
    folder to continue. The controllers stay unchanged."""
    own = options[0]
    chosen = own.chosen
    if own.list:
        return _conditions(chosen)
    if not tasks:
        raise TegotaeError("name a controller file, a folder, or a study's folder")
    require_count("starts", own.starts, most=64)
    require_free_for(own.out, GENERALISATION)
    names = sorted({task.name for task in tasks})
    asked = [task for task in tasks if _matches(task.name, own.only)]
    if not asked:
        raise TegotaeError(f"no model matches {own.only}; there are {', '.join(names[:3])}")
    tested = [task.tested(own.starts) for task in asked]
    done = run.generalise(tested, chosen, own.out, anew=own.anew)
    return Generalisation(done, chosen)


def _matches(name: str, pattern: str) -> bool:
    """Whether a set is asked for, by its model's name or with what differs in its training."""
    model = name.partition(" (")[0]
    return any(fnmatch.fnmatchcase(own, pattern) for own in (name, model))
