"""Robustness: trained controllers, unchanged, in conditions outside of their training."""

from __future__ import annotations

import fnmatch
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.tables import write_csv
from tegotae._support.workplace import GENERALISATION, require_free_for
from tegotae.analysis.generalisation import run
from tegotae.analysis.generalisation.disturbances import Disturbance, disturbances_named
from tegotae.api.controller import LoadedController
from tegotae.api.parameters import check_types
from tegotae.api.results import MatplotlibFigure, Table, short


@check_types
def list_conditions(*conditions: str) -> Table:
    """List the conditions outside of training and their levels.

    Controllers in another environment are tested at other frequencies, with weak or lagging
    actuators and with late or noisy senses; on a MuJoCo model also with other mass, gravity,
    friction and slope, and with pushes, wind and blows.

    Args:
        conditions: names, such as delay, or with your own levels, delay=0.01/0.02; all by default.

    Raises:
        TegotaeError: for a name that there is not.

    Example:
        >>> list_conditions("delay=0.01/0.02").table["levels"].tolist()
        ['0.01/0.02']
    """
    selection = _disturbances(conditions)
    rows = [(x.name, x.label, x.unit, f"{x.neutral:g}", _listed(x.levels)) for x in selection]
    table = pd.DataFrame(rows, columns=["condition", "what", "unit", "none", "levels"])
    indexed, data = table.set_index("condition"), {"conditions": table.to_dict("records")}
    return Table(rows=table, views=[indexed], data=data)


def _disturbances(conditions: Iterable[str]) -> tuple[Disturbance, ...]:
    """Return the conditions of names; all by default."""
    return disturbances_named([name for x in conditions for name in x.split(",")])


def _listed(levels: Iterable[float]) -> str:
    return "/".join(f"{level:g}" for level in sorted(levels))


@dataclass(frozen=True, repr=False, kw_only=True)
class Robustness(Table):
    """Range of each condition in which controllers keep their gait."""

    outcomes: Sequence[run.Done]
    disturbances: tuple[Disturbance, ...]

    @property
    def table(self) -> pd.DataFrame:
        """Margins, one row per controller, condition and side."""
        return self._margins([""]).drop(columns="measure")

    def texts(self) -> list[pd.DataFrame]:
        frame = self.table.rename(columns={"low": "from", "high": "to"})
        return [frame.map(short).set_index(["controller", "condition", "side"])]

    def to_dict(self) -> JsonObject:
        left_out = {tested.name: outcome.left_out for tested, outcome in self.outcomes}
        return as_json({"margins": self.table.to_dict("records"), "left_out": left_out})

    def figures(self) -> Mapping[str, MatplotlibFigure]:
        from tegotae.figures.generalisation import curves_figure

        return {"curves": curves_figure(self.outcomes, self.disturbances)}

    def _margins(self, measures: Iterable[str]) -> pd.DataFrame:
        rows = [
            (tested.name, measure, *margin)
            for tested, outcome in self.outcomes
            for measure in measures
            for margin in run.margins(outcome, self.disturbances, measure)
        ]
        return pd.DataFrame(rows, columns=["controller", "measure", *run.Margin._fields])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the margins by each measure, the curves, and the excluded runs."""
        curves = {tested.name: run.retention_curve(outcome) for tested, outcome in self.outcomes}
        left_out = [
            (tested.name, condition, reason)
            for tested, outcome in self.outcomes
            for condition, reason in outcome.left_out.items()
        ]
        return {
            "margins": self._margins(run.MEASURES),
            "curves": pd.concat(curves, names=["controller"]).reset_index("controller"),
            "left_out": pd.DataFrame(left_out, columns=["controller", "condition", "why"]),
        }

    def _fill(self, folder: Path) -> list[Path]:
        from tegotae.figures.style import save_figure

        paths = []
        for name, table in self.tables().items():
            path = folder / f"{name}.csv"
            path.unlink(missing_ok=True)  # of another run in this folder
            if len(table):
                write_csv(path, dict(table), digits=4)
                paths.append(path)
        return [*paths, save_figure(self.figures()["curves"], folder / "curves.png")]


def robustness(controllers: Sequence[LoadedController], options: Any) -> Robustness:
    """Test controllers in conditions outside of their training.

    Args:
        controllers: the controllers.
        options: those of `LoadedController.robustness`.
    """
    disturbances, out = _disturbances(options.conditions), Path(options.out)
    require_count("starts", options.starts, most=64)
    require_free_for(out, GENERALISATION)
    matching = [x for x in controllers if _matches(x.name, options.only)]
    if not matching:
        names = sorted({controller.name for controller in controllers})
        raise TegotaeError(f"no model matches {options.only}; there are {', '.join(names[:3])}")
    tested = [controller.tested(options.starts) for controller in matching]
    results = run.generalise(tested, disturbances, out, restart=options.restart)
    left_out = [(x.name, y.left_out) for x, y in results if y.left_out]
    notes = [
        *(f"{name} was left out of {json.dumps(reasons)[1:-1]}" for name, reasons in left_out),
        "Survived: the last level up to which more than half of the runs keep their "
        "undisturbed gait; failed: the next one tested, inf beyond the last. From, to: 95 % "
        "interval over runs.",
    ]
    return Robustness(outcomes=results, disturbances=disturbances, notes=notes)


def _matches(name: str, pattern: str) -> bool:
    """Return whether a name matches, or its model without the variant of its training."""
    model = name.partition(" (")[0]
    return any(fnmatch.fnmatchcase(candidate, pattern) for candidate in (name, model))
