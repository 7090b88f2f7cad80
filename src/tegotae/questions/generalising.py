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
from tegotae.analysis.generalisation.disturbances import Disturbance, disturbances_named
from tegotae.analysis.generalisation.run import (
    MEASURES,
    Done,
    Margin,
    curve,
    generalise,
    margins,
)
from tegotae.questions.answer import AnswerBase, short
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


@dataclass(frozen=True, repr=False)
class DisturbanceList(AnswerBase):
    """The conditions that there are."""

    chosen: tuple[Disturbance, ...]

    def frame(self) -> pd.DataFrame:
        """A row a condition."""
        rows = [
            (known.name, known.label, known.unit, f"{known.neutral:g}", _listed(known.levels))
            for known in self.chosen
        ]
        return pd.DataFrame(rows, columns=["condition", "what", "unit", "none", "levels"])

    def texts(self) -> list[pd.DataFrame]:
        return [self.frame().set_index("condition")]

    def document(self) -> JsonObject:
        return {"conditions": self.frame().to_dict("records")}  # type: ignore[dict-item]

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Nothing: nothing was tested."""
        return []


def _listed(levels: Iterable[float]) -> str:
    return "/".join(f"{level:g}" for level in sorted(levels))


@dataclass(frozen=True, repr=False)
class Generalisation(AnswerBase):
    """How much of each condition controllers bear."""

    done: Sequence[Done]
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
            for margin in margins(outcome, self.chosen, measure)
        ]
        return pd.DataFrame(rows, columns=["controller", "measure", *Margin._fields])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Margins by each measure, curves, and what was left out."""
        curves = {tested.name: curve(outcome) for tested, outcome in self.done}
        left_out = [
            (tested.name, condition, why)
            for tested, outcome in self.done
            for condition, why in outcome.left_out.items()
        ]
        return {
            "margins": self._margins(MEASURES),
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


def generalise_tasks(tasks: Sequence[Task], options: GeneralisationOptions) -> Generalisation:
    """Try controllers, and keep records of what they bear.

    Args:
        tasks: the controllers.
        options: the conditions and the folder.

    Raises:
        TegotaeError: for a condition or a controller that there is not, or a folder of other work.
    """
    require_count("starts", options.starts, most=64)
    require_free_for(options.out, GENERALISATION)
    names = sorted({task.name for task in tasks})
    asked = [task for task in tasks if _matches(task.name, options.only)]
    if not asked:
        raise TegotaeError(f"no model matches {options.only}; there are {', '.join(names[:3])}")
    tested = [task.tested(options.starts) for task in asked]
    done = generalise(tested, options.chosen, options.out, anew=options.anew)
    return Generalisation(done, options.chosen)


def _matches(name: str, pattern: str) -> bool:
    """Whether a set is asked for, by its model's name or with what differs in its training."""
    model = name.partition(" (")[0]
    return any(fnmatch.fnmatchcase(own, pattern) for own in (name, model))
