"""One table of equal comparisons: learned feedback, short laws and the clock over the best V.

The plan, fixed before the runs of other definitions of work and before episodes were restricted:

- All controllers are evaluated from the same releases. An episode without a limit cycle has merit
  0, and so has, in the rows of locked episodes, one whose hop rate is further from ω than
  `research.reproduction.learning.runs.LOCKED`.
- Whatever is chosen, a run, a law or a drive of V, is chosen at its ω_t by its mean on the first
  half of the releases, and judged on the other half. What is not chosen is judged on that half too.
- The base is the best V at an ω_t: one searched gain with one of three drives.
- Learned feedback is AR, ARG, ART and ARGT on [F_k], each with three drives: twelve designs. The
  mean of the runs is what one training gives on average; the chosen run is what 15 give.
- Choices differ in size: V has three drives, a design fifteen runs, and the laws ninety in all. So
  rows with equal choices stand beside: the best design by the mean of its runs, and the best of 15
  and of 90 runs of learned feedback and of laws alike. They were added after the other rows had
  been seen.
- V is searched, and the laws above are trained, which often fails. So laws that are searched stand
  beside (`research.reproduction.learning.searched`): of six by differential evolution, and of
  ninety by CMA-ES, the best on the first half of the releases. V's choice is among three. These
  rows, and those of locked episodes, were planned after the trained laws had been seen, and before
  any of their own runs.
- The 95 % interval is Student's, with designs and ω_t as crossed random effects (`crossed` in
  `claims/random_effects.py`); runs enter it through the mean or the choice of each design. A
  comparison that is chosen among laws has one value at each ω_t, and its interval is over these.

The rows are the same for each body and each definition of work.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.claims.random_effects import crossed
from research.reproduction.learning.runs import LAW, SEARCHED, where
from research.reproduction.report.markdown import markdown_table

CHOSEN, EVALUATED = "chosen", "judged"
"""Halves of the releases: columns `merit_chosen` and `merit_judged`, likewise `locked_…`."""
EPISODES = {"all": "merit", "locked": "locked"}
"""Outcomes by the episodes that count."""
EQUAL_CHOICES = (15, 90)
"""Numbers of runs among which both sides choose."""
DESIGN = ["architecture", "drive"]


class Comparison(NamedTuple):
    """Differences of merits, evaluated on the second half of the releases."""

    differences: np.ndarray
    """[designs, ω_t], in m/J."""
    omegas: tuple[float, ...]
    """Training frequencies ω_t [rad/s]."""

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the mean."""
        return crossed(self.differences)


def chosen(runs: pd.DataFrame, outcome: str, by: list[str]) -> pd.DataFrame:
    """Return the run of each group that is best on the first half of the releases."""
    order = runs.sort_values(f"{outcome}_{CHOSEN}", kind="stable")
    return order.drop_duplicates(by, keep="last")


def merits(runs: pd.DataFrame, outcome: str, by: list[str]) -> pd.DataFrame:
    """Return evaluated merits, one row per group and one column per ω_t."""
    return runs.pivot_table(f"{outcome}_{EVALUATED}", by, "omega_t", aggfunc="mean")


def best_of(runs: pd.DataFrame, outcome: str, number: int) -> pd.DataFrame:
    """Return the expected merit of the best of so many runs, drawn without replacement at each ω_t.

    Of N runs in the order of the choice, the k-th (from 0) is the best of n drawn ones with
    probability C(N-k-1, n-1) / C(N, n).

    Args:
        runs: rows of the runs to draw from.
        outcome: as of `comparisons`.
        number: number n of runs.

    Returns:
        One row, and one column per ω_t.
    """
    expected = {}
    for omega, rows in runs.groupby("omega_t"):
        order = rows.sort_values(f"{outcome}_{CHOSEN}", ascending=False, kind="stable")
        values, n = order[f"{outcome}_{EVALUATED}"].to_numpy(), min(number, len(order))
        counts = [math.comb(len(values) - k - 1, n - 1) for k in range(len(values))]
        expected[omega] = float(np.array(counts) / math.comb(len(values), n) @ values)
    return pd.DataFrame([expected])


def comparisons(runs: pd.DataFrame, outcome: str = "merit") -> dict[str, Comparison]:
    """Compare the controllers of one body.

    Args:
        runs: rows of `research.reproduction.learning.runs.run_rows`.
        outcome: `merit`, or `locked` for episodes that follow ω.

    Returns:
        Comparisons by name.
    """
    on_force = where(runs, runs.senses == "F")
    learned = where(on_force, on_force.architecture.isin(LEARNED_FEEDBACK))
    frequencies = learned.groupby(DESIGN).omega_t.transform("nunique")
    learned = where(learned, frequencies == frequencies.max())  # an unfinished study has other
    laws = where(on_force, on_force.architecture == LAW)

    def best(rows: pd.DataFrame) -> pd.DataFrame:
        return merits(chosen(rows, outcome, ["omega_t"]), outcome, ["senses"])

    def best_of_design(rows: pd.DataFrame) -> pd.DataFrame:
        return merits(chosen(rows, outcome, [*DESIGN, "omega_t"]), outcome, DESIGN)

    keys = [*DESIGN, "omega_t", "senses"]
    by_design = pd.DataFrame(learned.groupby(keys, as_index=False).mean(numeric_only=True))
    vanilla = best(where(on_force, on_force.architecture == "V"))
    mean, chosen_run = merits(learned, outcome, DESIGN), best_of_design(learned)
    pairs: dict[str, tuple[pd.DataFrame, pd.DataFrame]] = {
        "learned, mean of runs − best V": (mean, vanilla),
        "learned, best design, mean of runs − best V": (best(by_design), vanilla),
        "learned, chosen run − best V": (chosen_run, vanilla),
    }
    if len(laws):
        law = best(laws)
        pairs |= {
            "best short law − best V": (law, vanilla),
            "clock − best V": (best(where(laws, laws.drive == "clock")), vanilla),
            "learned, chosen run − best short law": (chosen_run, law),
        }
    for architecture in SEARCHED.values():
        if len(rows := where(on_force, on_force.architecture == architecture)):
            pairs |= {
                f"best {architecture} − best V": (best(rows), vanilla),
                f"learned, mean of runs − best {architecture}": (mean, best(rows)),
                f"learned, chosen run − best {architecture}": (chosen_run, best(rows)),
            }
    for n in EQUAL_CHOICES if len(laws) else ():
        equal = best_of(learned, outcome, n), best_of(laws, outcome, n)
        pairs[f"learned − short laws, best of {n} runs"] = equal
    return {name: _difference(*pair) for name, pair in pairs.items()}


def _difference(values: pd.DataFrame, base: pd.DataFrame) -> Comparison:
    omegas = [omega for omega in values.columns if omega in base.columns]
    difference = values[omegas].to_numpy() - base[omegas].to_numpy()
    return Comparison(difference, tuple(map(float, omegas)))


def contrast_rows(bodies: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the table: one row per body, comparison and kind of episodes; columns by ω_t, and all.

    Args:
        bodies: rows of runs by the name of their body, and of their work if it is another. Tables
            without columns of locked episodes have no rows of them.
    """
    rows = []
    for body, runs in bodies.items():
        outcomes = {x: y for x, y in EPISODES.items() if f"{y}_{EVALUATED}" in runs}
        for episodes, outcome in outcomes.items():
            for name, comparison in comparisons(runs, outcome).items():
                by_omega = comparison.differences.mean(axis=0)
                low, high = comparison.interval
                rows.append(
                    {
                        "body": body,
                        "episodes": episodes,
                        "comparison": name,
                        **{f"{w:g}": x for w, x in zip(comparison.omegas, by_omega, strict=True)},
                        "all": float(comparison.differences.mean()),
                        "low": low,
                        "high": high,
                    }
                )
    return pd.DataFrame(rows)


def contrast_table(rows: pd.DataFrame) -> str:
    """Return the rows in Markdown: over all ω_t, then by ω_t for each body and kind of episodes."""
    texts = ["body", "episodes", "comparison"]
    omegas = [name for name in rows if name not in (*texts, "all", "low", "high")]
    overall = [[*texts, "mean over ω_t [95 % interval]"]]
    for row in rows.to_dict("records"):
        interval = f"{row['all']:+.3f} [{row['low']:+.3f}, {row['high']:+.3f}]"
        overall.append([*(row[x] for x in texts), interval])
    tables = [overall]
    for kind, group in rows.groupby(rows["body"] + ", " + rows["episodes"], sort=False):
        by_omega = [[f"{kind} episodes", *omegas]]
        for row in group.to_dict("records"):
            by_omega.append([row["comparison"], *(f"{row[x]:+.2f}" for x in omegas)])
        tables.append(by_omega)
    return "\n".join(map(markdown_table, tables))
