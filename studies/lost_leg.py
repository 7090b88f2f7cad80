"""Walkers that lose a leg in mid-gait: the margin of the mass, who goes on, and what learning adds.

    python studies/lost_leg.py bodies     # vanilla feedback, leg by leg, with the margins
    python studies/lost_leg.py train      # feet that feel load, pitch and roll; legs lost meanwhile
    python studies/lost_leg.py report     # tables and the figure

Controllers are kept in `runs/lost_leg`, tables and the figure in `docs/_static/lost_leg`. A
training goes on where it was interrupted. About five CPU-minutes in all.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from kept import write_rows, write_text
from tegotae._support.tables import read_csv
from tegotae.cli.status import exit_status
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.support import support_margin_m
from tegotae.measures.objectives.walking import Walking
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import CorrectedFoot, EllipticFoot
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import OneOf, Uniform
from tegotae.studies.gaits.lesion import GaitLesion, aftermath
from tegotae.systems.experiment import Experiment
from tegotae.systems.legged import Legged
from tegotae.systems.legged_systems import hexapod, quadruped_c, settling, walking
from tegotae.training.algorithms import CMAES
from tegotae.training.collection import read
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run, train
from tegotae.training.stopping import Stopping

FOLDER = Path("runs/lost_leg")
TABLES = Path(__file__).resolve().parents[1] / "docs" / "_static" / "lost_leg"
STARTS = 64
"""Random releases of each case."""
TIMING = Timing(duration_s=100.0, tick_s=0.008, frame_s=0.08)
"""Of a release; the leg is lost at half of it."""
FAST = EllipticFoot(stride_m=0.264, lift_m=0.045, press_m=0.0, shift_rad=0.647)
"""Small quick steps, at which a walker can go on with three legs."""
OMEGA, SIGMA = 8.5, 1.9
MOVED = {"com_x_m": 0.326, "com_y_m": -0.206}
"""Where the mass is if the left hind leg is to be lost."""


def quick(**body: float) -> Legged:
    """Quadruped C with small quick steps, with these numbers of the body."""
    return walking("quadruped C, quick", Walker(**body), FAST, SIGMA, OMEGA)


def quick_hexapod() -> Legged:
    """The hexapod with the same steps."""
    return walking("hexapod, quick", hexapod().body, FAST, SIGMA, OMEGA)


BODIES = {
    "C, ω 2": quadruped_c,
    "C, quick": quick,
    "C, quick, mass moved": lambda: quick(**MOVED),
    "C, quick, mass ahead": lambda: quick(com_x_m=0.326),
    "C, quick, mass behind": lambda: quick(com_x_m=-0.326),
    "hexapod, ω 2": hexapod,
    "hexapod, quick": quick_hexapod,
}
"""Vanilla walkers that lose each leg in turn."""


@dataclass(frozen=True)
class Cell:
    """A training in which legs are lost.

    Args:
        name: of its folder.
        senses: what the feet feel.
        legged: makes the system.
        reach_m: how far a foot is shifted by an output of one [l0].
        generations: how many.
    """

    name: str
    senses: tuple[str, ...]
    legged: Any = quick
    reach_m: float = 0.3
    generations: int = 200
    seeds: int = 3

    @property
    def run(self) -> Run:
        """The training: an episode without loss and one of each leg, lost after 20 of 50."""
        own = self.legged()
        limbs = own.body.limbs
        hidden = 70 // (2 * (len(self.senses) + 2))
        foot = CorrectedFoot(self.senses, hidden, reach_m=self.reach_m, around=FAST)
        controller = dataclasses.replace(own.controller, actuation=foot)
        timing = Timing(duration_s=50.0, tick_s=0.0125, frame_s=0.1)
        system = dataclasses.replace(own.system, controller=controller, timing=timing)
        there = [tuple(float(k != lost) for k in range(limbs)) for lost in range(-1, limbs)]
        experiment = Experiment(
            name=self.name,
            system=system,
            objective=Walking(speed_m_per_s=0.6, settle_s=30.0),
            conditions=(
                OneOf("present", from_s=20.0, values=tuple(there)),
                Uniform("phase_rad", low=0.0, high=2.0 * math.pi),
            ),
            episodes=len(there),
        )
        return Run(
            experiment=experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(
                algorithm=CMAES(population=24, std=0.3),
                stopping=Stopping.after(self.generations),
            ),
        )


CELLS = (
    Cell("feels-load", ("spring_force",)),
    Cell("feels-angles", ("spring_force", "pitch", "roll")),
    Cell("feels-rates", ("spring_force", "pitch", "roll", "pitch_rate", "roll_rate")),
    Cell("hexapod", ("spring_force", "pitch", "roll"), quick_hexapod),
)


def lost(name: str, run: str, legged: Legged) -> list[dict[str, Any]]:
    """A row per leg: who goes on when it is lost in mid-gait."""
    rows = []
    for number, leg in enumerate(legged.names):
        lesion = GaitLesion(at_s=0.5 * TIMING.duration_s, lost=(leg,))
        found = aftermath(legged, lesion, STARTS, timing=TIMING)
        after = found.after
        walks = found.stays & (after.distance_m > 2.0)
        rows.append(
            {
                "body": name,
                "run": run,
                "leg": leg,
                "margin": support_margin_m(legged.body, (number,)),
                "stood": int(found.stood.sum()),
                "stays_up": int(found.stays.sum()),
                "walks_on": int(walks.sum()),
                "speed_before": _median(found.before.speed_m_per_s[found.stood]),
                "speed": _median(after.speed_m_per_s[walks]),
                "cost_of_transport": _median(after.cost_of_transport[walks]),
                "falls_after": _median(after.fall_time_s[found.stood & ~found.stays]),
            }
        )
    return rows


def _median(values: np.ndarray) -> float:
    return float(np.median(values)) if len(values) else math.nan


@dataclass(frozen=True)
class Bodies:
    """Vanilla walkers that lose each leg in turn."""

    def run(self) -> None:
        """Evaluate, and write the table."""
        rows = [row for name, make in BODIES.items() for row in lost(name, "", make())]
        write_rows(TABLES / "bodies.csv", rows, digits=4)


@dataclass(frozen=True)
class Train:
    """Train with legs lost in mid-episode, and evaluate."""

    only: tuple[str, ...] = ()
    """Names of trainings; all by default."""
    dir: Path = FOLDER

    def run(self) -> None:
        """Train what is missing, and write the table."""
        for cell in CELLS:
            if self.only and cell.name not in self.only:
                continue
            train(cell.run, self.dir / cell.name)
            (runs,) = read(self.dir / cell.name)
            rows = []
            for label, weights in zip(runs.labels, runs.weights, strict=True):
                rows += lost(cell.name, str(label), settling(runs.system, weights))
            write_rows(TABLES / "learned.csv", rows, digits=4, by=("body",))


@dataclass(frozen=True)
class Report:
    """The tables in Markdown, and the figure."""

    def run(self) -> None:
        """Write them."""
        names = [name for name in ("bodies", "learned") if (TABLES / f"{name}.csv").exists()]
        for name in names:
            write_text(TABLES / f"{name}.md", markdown(read_csv(TABLES / f"{name}.csv")))
        with styled():
            save_figure(draw([read_csv(TABLES / f"{name}.csv") for name in names]),
                        TABLES / "lost_leg.png")  # fmt: skip


def markdown(table: dict[str, np.ndarray]) -> str:
    """A row a leg."""
    titles = ("walker", "leg lost", "margin [l0]", "stays up", "walks on", "speed before",
              "speed after", "CoT after", "falls after")  # fmt: skip
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    for cells in zip(*table.values(), strict=True):
        row = dict(zip(table, (str(c) for c in cells), strict=True))

        def number(name: str, digits: int = 2, row: dict[str, str] = row) -> str:
            return f"{float(row[name]):.{digits}f}" if row[name] else "–"

        name = row["body"] + (f", run {row['run']}" if row["run"] else "")
        stood = row["stood"]
        own = (name, row["leg"], number("margin"), f"{row['stays_up']} of {stood}",
               f"{row['walks_on']} of {stood}", number("speed_before"), number("speed"),
               number("cost_of_transport"), number("falls_after", 1))  # fmt: skip
        lines.append(f"| {' | '.join(own)} |")
    return "\n".join(lines) + "\n"


def draw(tables: list[dict[str, np.ndarray]]) -> Any:
    """Share of the starts that walk on over the margin, one mark a walker and leg."""
    figure = new_figure(PAGE_IN, 2.8)
    axes = figure.subplots()
    marks = "os^DvPX<*h>d"
    number = 0
    for learned, table in enumerate(tables):
        for name in dict.fromkeys(table["body"].tolist()):
            own = table["body"] == name
            margin = np.array(table["margin"], float)[own]
            share = np.array(table["walks_on"], float)[own]
            share = share / np.maximum(np.array(table["stood"], float)[own], 1.0)
            jitter = 0.004 * (number - 5)
            axes.plot(
                margin + jitter, share, marks[number % len(marks)], ms=5, alpha=0.8,
                mfc="none" if learned else None, color=COLOURS[number % 7],
                label=f"learned, {name}" if learned else name,
            )  # fmt: skip
            number += 1
    axes.axvline(0.0, color="0.7", lw=0.6)
    axes.set_xlabel("margin of the mass inside the remaining feet [l0]")
    axes.set_ylabel("share that walks on")
    axes.set_ylim(-0.05, 1.05)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")
    return figure


if __name__ == "__main__":
    command = tyro.cli(
        Annotated[Bodies, tyro.conf.subcommand("bodies")]
        | Annotated[Train, tyro.conf.subcommand("train")]
        | Annotated[Report, tyro.conf.subcommand("report")]
    )
    sys.exit(exit_status(command.run))
