"""`tegotae figure learning-curves`: algorithms on the same policies (Fig. 3)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro

from tegotae.cli.console import print_rows, print_text
from tegotae.cli.figure.output import Output

if TYPE_CHECKING:
    from tegotae.measures.hopping.statistics import Interval
    from tegotae.training.curves import LearningCurve


_OF = tyro.conf.arg(help_behavior_hint="(default: CoT⁻¹ if all measured it, else fitness)")


@dataclass(frozen=True, kw_only=True)
class LearningCurves(Output):
    """CoT⁻¹ or fitness during training, over episodes and over simulated time (Fig. 3)."""

    runs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Folders of trainings, searched with their subfolders, or tables that this command wrote."""
    of: Annotated[Literal["cot_inverse", "fitness"] | None, _OF] = None
    """Quantity of the curves."""

    def run(self) -> None:
        """Read, write, and print how the algorithms compare."""
        from tegotae._support.errors import TegotaeError
        from tegotae.figures.learning_curves import algorithms_figure, algorithms_tables
        from tegotae.training.curves import read_curves

        if not self.runs:
            raise TegotaeError("no trainings to draw; name their folders")
        self.check_out()
        curves = read_curves(self.runs, self.of)
        self.write(algorithms_figure(curves), algorithms_tables(curves))
        print_comparison(curves)


def print_comparison(curves: list[LearningCurve]) -> None:
    """Late in training: each algorithm, and how far PGPE is above it on the same model."""
    from tegotae.measures.hopping.registry import range_of
    from tegotae.measures.hopping.statistics import UNBOUNDED, difference, interval
    from tegotae.training.curves import COT, groups

    is_cot = curves[0].measure == COT
    within = range_of(COT) if is_cot else UNBOUNDED
    called = "CoT⁻¹" if is_cot else "fitness"
    found = groups(curves)
    until = {
        model: min(c.simulated_s[-1] for c in curves if c.model == model) for model, _ in found
    }

    def row(model: str, algorithm: str) -> tuple[str, ...]:
        runs, pgpe = found[model, algorithm], found.get((model, "pgpe"), [])
        cells = [model, algorithm, str(len(runs))]
        for time in (np.inf, until[model]):
            own = [run.late_mean(time) for run in runs]
            cells.append(_words(interval(own, within=within)))
            other = [run.late_mean(time) for run in pgpe]
            compares = bool(pgpe) and algorithm != "pgpe"
            cells.append(_words(difference(other, own)) if compares else "")
        return (*cells[:3], f"{runs[0].simulated_s[-1]:.0f} s", *cells[3:])

    print_rows(
        (
            "model",
            "algorithm",
            "runs",
            "learned from",
            f"{called} at the end",
            "PGPE's lead",
            f"{called} after equal simulated time",
            "PGPE's lead",
        ),
        (row(*key) for key in sorted(found)),
        key=2,
    )
    print_text(
        "Mean over runs of the mean over the last tenth of training [95 % interval]; "
        "equal time: that of the shortest run of the model."
    )


def _words(found: Interval) -> str:
    if np.isnan(found.low):
        return f"{found.mean:.3f}"
    return f"{found.mean:.3f} [{found.low:.3f}, {found.high:.3f}]"
