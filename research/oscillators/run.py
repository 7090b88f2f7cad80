"""Does the oscillator matter: the paper's architectures with each oscillator, given and trained.

    python -m research.oscillators.run               # what is missing of it; hours on two cores
    python -m research.oscillators.run --omegas 8 --seeds 5
    python -m research.oscillators.run --tables-only # only tables and figure anew

Every architecture is trained to its plateau with every oscillator, from the same seeds, with the
same budget of 96 weights, and evaluated as the paper does. The records are kept in a folder, so
that the same command goes on where another one ended. Written to `research/oscillators` are
`matter.csv`, a row per run, and for each frequency `matter-w8.md`, the differences from the phase
oscillator, and `matter-w8.png`. Rows of the table that the folder has no records of stay.

A Hopf oscillator with given numbers is not trained: as feedback only turns it, every rollout is
that of the phase oscillator to the bit (`tests/parts/test_planar_oscillators.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from research.frame import main, markdown_table, write_rows, write_text
from research.reproduction.folder import Folder
from research.reproduction.plan import Plan
from research.reproduction.runner import run_study
from research.reproduction.table import tabulate
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder
from tegotae._support.tables import read_csv
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.statistics import interval, stratified_difference
from tegotae.parts.oscillators import OSCILLATORS, PHASE
from tegotae.study import on_cores
from tegotae.systems.recipe import recipe

DOCS = Path(__file__).resolve().parents[2] / "docs"

ARCHITECTURES = ("V", "VG", "VT", "VGT", "AR", "ART", "ARG", "ARGT")
"""The paper's, each by its plainest member: on F_k alone, with reflex, or T on [φ, f]."""
COMPARED = tuple(name for name in OSCILLATORS if name != "hopf")
CELL = ("architecture", "oscillator", "omega_t")
SHOWN = {
    "best_fitness": "fitness [m/J]",
    "cot_inverse": "CoT⁻¹ [m/J]",
    "delta_omega": "ΔΩ [rad²/s²]",
    "limit_cycle_share": "settled share",
    "recovery_share": "recovered share",
}
"""Columns of a run that are listed, with their labels."""
_TITLES = {
    "hopf": "Hopf",
    "adaptive-hopf": "adaptive Hopf",
    "van-der-pol": "van der Pol",
    "matsuoka": "Matsuoka",
}


@dataclass(frozen=True)
class Matter:
    """Train and evaluate what is missing, and write table and figure."""

    omegas: tuple[float, ...] = (8.0, 4.0)
    """Training frequencies ω_t [rad/s]."""
    oscillators: tuple[str, ...] = COMPARED
    """Oscillators; the phase oscillator is always among them."""
    architectures: tuple[str, ...] = ARCHITECTURES
    """Architectures."""
    seeds: int = 10
    """Runs of each."""
    dir: Path = Path("runs/oscillators")
    """Folder of the records."""
    workers: int | None = None
    """Worker processes; one a core by default."""
    out: Path = DOCS.parent / "research" / "oscillators"
    """Folder of table and figure."""
    tables_only: bool = False
    """Only tabulate what the folder holds."""

    def run(self) -> None:
        """Run the whole study."""
        output_folder(self.out)
        if not self.tables_only:
            run_study(self.plan, self.dir, partial(on_cores, workers=self.workers))
        columns = self._columns()
        results = [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ]
        write_rows(self.out / "matter.csv", results, digits=5, by=CELL)
        rows = read_csv(self.out / "matter.csv", (*CELL, *SHOWN))
        for omega in np.unique(rows["omega_t"]):
            selection = _where(rows, rows["omega_t"] == omega)
            write_text(self.out / f"matter-w{omega}.md", markdown(selection))
            save_figure(draw(selection), self.out / f"matter-w{omega}.png")

    @property
    def plan(self) -> Plan:
        """Return the plan of trainings and evaluations."""
        names = dict.fromkeys((PHASE, *self.oscillators))
        experiments = tuple(
            recipe(model_name(architecture, oscillator, omega)).experiment()
            for oscillator in names
            for architecture in self.architectures
            for omega in self.omegas
        )
        return Plan(scale="quick", experiments=experiments, seeds=self.seeds, budgets=())

    def _columns(self) -> dict[str, Any]:
        records, damaged = Folder(self.dir).all()
        if damaged or not records:
            raise TegotaeError("; ".join(damaged) or f"{self.dir} holds no records")
        table = tabulate(records)
        parts = [name.partition("+") for name in table["model"]]
        place = {
            "architecture": [model.partition("-")[0] for model, _, _ in parts],
            "oscillator": [oscillator or PHASE for _, _, oscillator in parts],
        }
        fields = ("omega_t", "run", "best_fitness", "episodes_trained", "ended")
        measured = tuple(m.name for m in HOPPING.metrics() if m.name in table.columns)
        return {**place, **{name: table[name] for name in (*fields, *measured)}}


def model_name(architecture: str, oscillator: str, omega: float) -> str:
    """Return the name of the architecture's plainest member, at a training frequency, with an
    oscillator.
    """
    plain = recipe(architecture).name.removesuffix("-w8")
    return f"{plain}-w{omega:g}" + ("" if oscillator == PHASE else f"+{oscillator}")


def column(rows: dict[str, Any], name: str) -> np.ndarray:
    """Return a column of numbers, NaN where it is empty; without hopping no work is useful, 0
    m/J.
    """
    values = np.array([float(x) if x != "" else math.nan for x in rows[name]])
    return np.maximum(values, 0.0) if name == "best_fitness" else values


def compared(rows: dict[str, Any], oscillator: str, name: str) -> tuple[float, float, float]:
    """Return the mean difference from the phase oscillator and its 95 % interval.

    Architecture by architecture and frequency by frequency, and then the mean over these.
    """
    values = column(rows, name)
    strata = []
    for cell in sorted(set(zip(rows["architecture"], rows["omega_t"], strict=True))):
        inside = (np.asarray(rows["architecture"]) == cell[0]) & (
            np.asarray(rows["omega_t"]) == cell[1]
        )
        ours, theirs = (
            values[inside & (np.asarray(rows["oscillator"]) == candidate)]
            for candidate in (oscillator, PHASE)
        )
        if len(ours) and len(theirs):
            strata.append((ours, theirs))
    estimate = stratified_difference(strata)
    return estimate.mean, estimate.low, estimate.high


def markdown(rows: dict[str, Any]) -> str:
    """Return the differences as tables in Markdown: where terms are learned, and of V alone."""
    vanilla = np.asarray(rows["architecture"]) == "V"
    parts = (("learned terms", ~vanilla), ("V", vanilla))
    return "\n".join(_table(title, _where(rows, inside)) for title, inside in parts)


def _where(rows: dict[str, Any], inside: np.ndarray) -> dict[str, Any]:
    return {name: np.asarray(values)[inside] for name, values in rows.items()}


def _table(title: str, rows: dict[str, Any]) -> str:
    present = [name for name in COMPARED if name in set(rows["oscillator"]) and name != PHASE]
    lines = [[title, *SHOWN.values()]]
    with_phase = np.asarray(rows["oscillator"]) == PHASE
    means = [interval(column(rows, name)[with_phase]).mean for name in SHOWN]
    lines.append(["phase: mean", *(f"{mean:.3f}" for mean in means)])
    for oscillator in present:
        cells = (compared(rows, oscillator, name) for name in SHOWN)
        differences = (f"{mean:+.3f} ({low:+.3f} … {high:+.3f})" for mean, low, high in cells)
        lines.append([oscillator, *differences])
    return markdown_table(lines)


def title(oscillator: str) -> str:
    """Return the title of an oscillator in the figure."""
    name = oscillator.removeprefix("learned-")
    text = _TITLES.get(name, name)
    return text if name == oscillator else f"{text}, learned"


def draw(rows: dict[str, Any]) -> Figure:
    """Draw fitness and share of settled gaits: one mark per run, a line at the mean of an
    architecture.
    """
    metrics = ("best_fitness", "limit_cycle_share")
    present = [name for name in COMPARED if name in set(rows["oscillator"])]
    architectures = [name for name in ARCHITECTURES if name in set(rows["architecture"])]
    where = {name: np.asarray(rows[name]) for name in ("architecture", "oscillator")}
    with styled():
        figure = new_figure(PAGE_IN, 4.4)
        panels = figure.subplots(len(metrics), 1, sharex=True)
        width = 0.8 / len(present)
        for panel, name in zip(panels, metrics, strict=True):
            values = column(rows, name)
            for position, oscillator in enumerate(present):
                colour = COLOURS[position % len(COLOURS)]
                for place, architecture in enumerate(architectures):
                    inside = where["architecture"] == architecture
                    y = values[inside & (where["oscillator"] == oscillator)]
                    x = place - 0.4 + (position + 0.5) * width
                    label = title(oscillator) if place == 0 else None
                    panel.plot(np.full(len(y), x), y, ".", color=colour, ms=3, alpha=0.6)
                    if np.isfinite(y).any():
                        ends = [x - 0.4 * width, x + 0.4 * width]
                        panel.plot(ends, [np.nanmean(y)] * 2, color=colour, lw=1.8, label=label)
            panel.set_ylabel(SHOWN[name])
        panels[-1].set_xticks(range(len(architectures)), architectures)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


if __name__ == "__main__":
    main(Matter)
