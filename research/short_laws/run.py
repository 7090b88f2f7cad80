"""Measure the gain from learning: short laws of two to five numbers beside the learned controllers.

    python -m research.short_laws.run  # what is missing of it; ten minutes on two cores
    python -m research.short_laws.run --seeds 5 --omegas 4
    python -m research.short_laws.run --tables-only # only the table anew

Every short law (`tegotae.systems.term_sets`) is trained as the paper's models are: by PGPE to its
plateau, from the same seeds, released from the same height, on the study's body, and evaluated
like them. Beside them stand learned controllers, trained alike, and vanilla ones, whose gain a
search finds. A run's merit is its mean CoT⁻¹
over the five frequencies of the evaluation, one without a limit cycle counted as 0, since the
fitness at the frequency of the training saturates. Its following is the slope of the hop rate over
the commanded ω, of the frequencies with a limit cycle: 1 follows the command, 0 ignores it.

Written to `research/short_laws` are `runs.csv`, a row per run, and `short_laws.md`, means with
95 % intervals over runs. Trainings are kept in a folder, and go on where another call ended.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import tegotae as tg
from research.frame import main, markdown_table, with_interval, write_rows, write_text
from tegotae.systems.resolve import resolve
from tegotae.systems.term_sets import LAWS

DOCS = Path(__file__).resolve().parents[2] / "docs"
VANILLA = ("V-sector", "V-reflex")
LEARNED = ("ART-rF-tphi", "ART-rF-tphif", "ARGT-rF-gF-tphi")


@dataclass(frozen=True)
class ShortLaws:
    """Train short laws, and compare them with the learned controllers."""

    omegas: tuple[float, ...] = (4.0, 8.0)
    """Frequencies of the training [rad/s]."""
    seeds: int = 15
    """Runs of each law."""
    dir: Path = Path("results/short_laws")
    """Folder of the trainings."""
    out: Path = DOCS.parent / "research" / "short_laws"
    """Folder of the tables."""
    to_cap: bool = False
    """Train for all generations; name another `--dir` and `--out`."""
    tables_only: bool = False
    """Make the table of what `runs.csv` holds."""

    def run(self) -> None:
        """Train, evaluate, and write."""
        file = self.out / "runs.csv"
        if not self.tables_only:
            runs = pd.concat([self._runs_at(omega) for omega in self.omegas])
            write_rows(file, runs.to_dict("records"), digits=6, by=("omega_t_rad_per_s",))
        runs = pd.read_csv(file)
        write_text(self.out / "short_laws.md", table(runs))
        print(table(runs))

    def _runs_at(self, omega: float) -> pd.DataFrame:
        rows = []
        for name in (*VANILLA, *LAWS, *LEARNED):
            label = f"{name}-w{omega:g}"
            numbers = resolve(label).experiment().controller.n_weights
            subject = label if name in VANILLA else str(self._trained(label))
            rows.append(merits(subject, name, numbers, omega))
        return pd.concat(rows)

    def _trained(self, name: str) -> Path:
        tg.train(name, seeds=self.seeds, out=self.dir / name, to_cap=self.to_cap)
        return self.dir / name


def merits(subject: str, name: str, numbers: int, omega: float) -> pd.DataFrame:
    """Return merit, settled share and following of every run."""
    scores = tg.load(subject).evaluate().table

    def of_run(run: pd.DataFrame) -> pd.Series:
        settled = run.limit_cycle_share.to_numpy() > 0.0
        rate, command = run.hop_rate[settled], run.omega[settled]
        slope = np.polyfit(command, rate, 1)[0] if settled.sum() > 1 else np.nan
        return pd.Series(
            {
                "merit_m_per_j": run.cot_inverse.fillna(0.0).mean(),
                "settled_share": run.limit_cycle_share.mean(),
                "following": slope,
            }
        )

    runs = scores.groupby("run").apply(of_run, include_groups=False).reset_index()
    runs.insert(0, "controller", name)
    runs.insert(1, "numbers", numbers)
    runs.insert(2, "omega_t_rad_per_s", omega)
    return runs


def table(runs: pd.DataFrame) -> str:
    """Return means over runs with their intervals, and the best run, in Markdown."""
    lines = [
        ["ω_t", "controller", "numbers", "merit [m/J]", "best run", "settled share", "following"]
    ]
    for _, rows in runs.groupby(["omega_t_rad_per_s", "controller"], sort=False):
        omega, name = rows.omega_t_rad_per_s.iloc[0], rows.controller.iloc[0]
        merit = with_interval(rows.merit_m_per_j, ".3f", (0.0, math.inf))
        share = with_interval(rows.settled_share, ".3f", (0.0, 1.0))
        following = with_interval(rows.following, ".3f")
        numbers, best = rows.numbers.iloc[0], f"{rows.merit_m_per_j.max():.3f}"
        lines.append([f"{omega:g}", name, numbers, merit, best, share, following])
    return markdown_table(lines)


if __name__ == "__main__":
    main(ShortLaws)
