"""`tegotae evaluate`: the paper's evaluation of controllers."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae.cli.options import UNSET
from tegotae.cli.tables import print_rows
from tegotae.collection import Runs, read
from tegotae.errors import require_finite
from tegotae.evaluation import METRICS, Evaluation, Protocol, evaluate
from tegotae.files import output_file, write_atomically
from tegotae.limits import MOST_RAD_PER_S
from tegotae.metrics.statistics import Interval
from tegotae.progress import reporting

_SHOWN = {
    "cot_inverse": "CoT⁻¹ A [m/J]",
    "optimum_share": "of optimum",
    "cot_inverse_total": "CoT⁻¹ B [m/J]",
    "t0_s": "T0 [s]",
    "t1_s": "T1 [s]",
    "delta_omega": "ΔΩ",
    "delta_w": "Δw [rad/s]",
    "cpgu": "CPGu",
    "limit_cycle_share": "limit cycles",
    "smoothness": "dF/dt [1/s]",
}


@dataclass(frozen=True)
class Evaluate:
    """Evaluate a controller file, a folder of them, or a pure V model, at five frequencies."""

    place: Annotated[str, tyro.conf.Positional]
    """A controller file, a folder, or the name of a pure V model such as V-sector-w4."""
    omega: Annotated[float | None, UNSET] = None
    """Evaluate around this frequency [rad/s] instead of the one trained at."""
    drop: float = 0.2
    """How far the ground drops [m]."""
    undisturbed: float = 40.0
    """Time from the release to the drop [s]."""
    disturbed: float = 40.0
    """Time after that [s]."""
    energy: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Also write one row per run to this file."""

    def run(self) -> None:
        """Evaluate, and print."""
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        protocol = Protocol(
            drop_m=self.drop,
            undisturbed_s=self.undisturbed,
            disturbed_s=self.disturbed,
            work=self.energy,
        )
        if self.csv is not None:
            output_file(self.csv)
        found = evaluate_all(read(self.place), protocol, self.omega)
        if self.csv is not None:
            write_atomically(self.csv, _rows(found))
        if self.json:
            controllers = [{"name": r.name, "labels": r.labels, **e.to_dict()} for r, e in found]
            print(json.dumps({"controllers": controllers}))
            return
        print_table(found)


def evaluate_all(
    sets: list[Runs], protocol: Protocol, omega: float | None = None
) -> list[tuple[Runs, Evaluation]]:
    """Evaluate sets of runs, showing how far it is."""
    found = []
    with reporting("evaluate", len(sets)) as reporter:
        for done, runs in enumerate(sets, 1):
            # A frequency asked for does not give one to a controller without an oscillator.
            omega_t = runs.omega_t if omega is None or runs.omega_t is None else omega
            asked = dataclasses.replace(runs, omega_t=omega_t)
            result = evaluate(runs.controller, runs.weights, omega_t, runs.body, protocol)
            found.append((asked, result))
            reporter.update(done, runs.name)
    return found


def print_table(found: list[tuple[Runs, Evaluation]]) -> None:
    """One row per set of runs: mean and 95 % interval of each metric over the runs."""
    summaries = [evaluation.summary() for _, evaluation in found]
    print_rows(
        ("controller", "runs", *_SHOWN.values()),
        (
            (runs.name, str(evaluation.n_runs), *(show(summary[name]) for name in _SHOWN))
            for (runs, evaluation), summary in zip(found, summaries, strict=True)
        ),
    )
    print(
        "Mean over runs [95 % interval]. A body at rest has CoT⁻¹ 0; hopping without a "
        "limit cycle has neither CoT⁻¹ nor transients, and counts in the share of limit cycles. "
        "– is undefined, * means that some runs are."
    )


def show(value: Interval) -> str:
    """An interval in a table."""
    if math.isnan(value.mean):
        return "–"
    mark = "*" if value.undefined else ""
    if math.isnan(value.low):
        return f"{value.mean:.3g}{mark}"
    return f"{value.mean:.3g}{mark} [{value.low:.3g}, {value.high:.3g}]"


def _rows(found: list[tuple[Runs, Evaluation]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["controller", "run", "omega_t_rad_per_s", *METRICS])
    for runs, evaluation in found:
        values = evaluation.runs()
        for i, label in enumerate(runs.labels):
            row = (values[name][i] for name in METRICS)
            omega = "" if runs.omega_t is None else f"{runs.omega_t:g}"
            writer.writerow(
                [runs.name, label, omega, *("" if math.isnan(v) else f"{v:.6g}" for v in row)]
            )
    return stream.getvalue()
