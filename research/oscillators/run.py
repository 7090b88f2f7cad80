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

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from research.frame import Row, main, markdown_table, write_rows, write_text
from research.reproduction.folder import Folder
from research.reproduction.plan import Plan
from research.reproduction.runner import run_study
from research.reproduction.table import tabulate
from tegotae._support.errors import TegotaeError
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.statistics import Interval, interval, stratified_difference
from tegotae.parts.oscillators import OSCILLATORS, PHASE
from tegotae.study import on_cores
from tegotae.systems.recipe import recipe

DOCS = Path(__file__).resolve().parents[2] / "docs"

ARCHITECTURES = ("V", "VG", "VT", "VGT", "AR", "ART", "ARG", "ARGT")
"""The paper's, each by its plainest member: on F_k alone, with reflex, or T on [φ, f]."""
COMPARED = tuple(name for name in OSCILLATORS if name not in ("hopf", PHASE))
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
        if not self.tables_only:
            run_study(self.plan, self.dir, partial(on_cores, workers=self.workers))
        write_rows(self.out / "matter.csv", self._rows(), digits=5, by=CELL)
        table = pd.read_csv(self.out / "matter.csv")
        table = table.assign(best_fitness=table.best_fitness.clip(lower=0.0))
        for omega, rows in table.groupby("omega_t"):
            write_text(self.out / f"matter-w{omega:g}.md", markdown(rows))
            save_figure(draw(rows), self.out / f"matter-w{omega:g}.png")

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

    def _rows(self) -> list[Row]:
        records, damaged = Folder(self.dir).all()
        if damaged or not records:
            raise TegotaeError("; ".join(damaged) or f"{self.dir} holds no records")
        table = pd.DataFrame(tabulate(records).columns)
        names = table.model.str.partition("+")
        table["architecture"] = names[0].str.partition("-")[0]
        table["oscillator"] = names[2].where(names[2] != "", PHASE)
        fields = ("architecture", "oscillator", "omega_t", "run", "best_fitness")
        measured = (m.name for m in HOPPING.metrics() if m.name in table)
        return table[[*fields, "episodes_trained", "ended", *measured]].to_dict("records")


def model_name(architecture: str, oscillator: str, omega: float) -> str:
    """Return the name of the architecture's plainest member, at a training frequency, with an
    oscillator.
    """
    plain = recipe(architecture).name.removesuffix("-w8")
    return f"{plain}-w{omega:g}" + ("" if oscillator == PHASE else f"+{oscillator}")


def compared(rows: pd.DataFrame, oscillator: str, name: str) -> Interval:
    """Return the mean difference of a column from the phase oscillator, with its interval.

    Architecture by architecture, and then the mean over these.
    """
    strata = []
    for _, cell in rows.groupby("architecture"):
        pair = [cell[name][cell.oscillator == x].to_numpy() for x in (oscillator, PHASE)]
        if all(map(len, pair)):
            strata.append(pair)
    return stratified_difference(strata)


def markdown(rows: pd.DataFrame) -> str:
    """Return the differences as tables in Markdown: where terms are learned, and of V alone."""
    vanilla = rows.architecture == "V"
    parts = (("learned terms", rows[~vanilla]), ("V", rows[vanilla]))
    return "\n".join(_table(title, part) for title, part in parts)


def _table(title: str, rows: pd.DataFrame) -> str:
    with_phase = rows[rows.oscillator == PHASE]
    means = (interval(with_phase[name].to_numpy()).mean for name in SHOWN)
    lines = [[title, *SHOWN.values()], ["phase: mean", *(f"{mean:.3f}" for mean in means)]]
    for oscillator in _present(rows)[1:]:
        cells = (compared(rows, oscillator, name) for name in SHOWN)
        lines.append(
            [oscillator, *(f"{x.mean:+.3f} ({x.low:+.3f} … {x.high:+.3f})" for x in cells)]
        )
    return markdown_table(lines)


def _present(rows: pd.DataFrame) -> list[str]:
    """Return the oscillators in a table, the phase first."""
    return [name for name in (PHASE, *COMPARED) if name in set(rows.oscillator)]


def title(oscillator: str) -> str:
    """Return the title of an oscillator in the figure."""
    name = oscillator.removeprefix("learned-")
    text = _TITLES.get(name, name)
    return text if name == oscillator else f"{text}, learned"


def draw(rows: pd.DataFrame) -> Figure:
    """Draw fitness and share of settled gaits: one mark per run, a line at the mean of an
    architecture.
    """
    present = _present(rows)
    architectures = [name for name in ARCHITECTURES if name in set(rows.architecture)]
    width = 0.8 / len(present)
    with styled():
        figure = new_figure(PAGE_IN, 4.4)
        panels = figure.subplots(2, 1, sharex=True)
        for panel, name in zip(panels, ("best_fitness", "limit_cycle_share"), strict=True):
            for position, oscillator in enumerate(present):
                colour = COLOURS[position % len(COLOURS)]
                for place, architecture in enumerate(architectures):
                    mine = (rows.architecture == architecture) & (rows.oscillator == oscillator)
                    y, x = rows[name][mine], place - 0.4 + (position + 0.5) * width
                    label = title(oscillator) if place == 0 else None
                    panel.plot(np.full(len(y), x), y, ".", color=colour, ms=3, alpha=0.6)
                    ends = [x - 0.4 * width, x + 0.4 * width]
                    panel.plot(ends, [y.mean()] * 2, color=colour, lw=1.8, label=label)
            panel.set_ylabel(SHOWN[name])
        panels[-1].set_xticks(range(len(architectures)), architectures)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


if __name__ == "__main__":
    main(Matter)
