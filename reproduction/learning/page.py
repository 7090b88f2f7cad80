"""What learning adds, as tables in Markdown: the primary contrasts, and every group of runs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from reproduction.learning.primary import BEST_RUN, MEAN_RUN, Contrast, best_law, contrast
from reproduction.learning.runs import LAW
from tegotae.measures.hopping.statistics import SHARE, UNBOUNDED, Range, interval

_MERIT: Range = (0.0, np.inf)


def contrasts(runs: pd.DataFrame) -> list[tuple[str, str, Contrast]]:
    """The primary contrasts and their sensitivity: what is compared, how, and the contrast."""
    law = best_law(runs)
    pairs = [("V", None, "merit"), (f"the best short law, {law}", law, "merit_judged")]
    found = []
    for run in (MEAN_RUN, BEST_RUN):
        found += [
            (f"merit over {base}", run, contrast(runs, name, outcome=outcome, run=run))
            for base, name, outcome in pairs
        ]
    found.append(("settled share over V", MEAN_RUN, contrast(runs, outcome="settled")))
    settled = (
        "settled share over " + pairs[1][0],
        MEAN_RUN,
        contrast(runs, law, outcome="settled"),
    )
    return [*found, settled]


def primary_table(readings: Mapping[str, pd.DataFrame]) -> str:
    """The contrasts of each body, in Markdown."""
    lines = [
        "| body | learned feedback's | of | effect | designs and ω_t random | runs alone; "
        "bootstrap | base | by ω_t |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for body, runs in readings.items():
        for what, run, c in contrasts(runs):
            by = ", ".join(f"{omega:g}: {value:+.2f}" for omega, value in c.of_omega.items())
            lines.append(
                f"| {body} | {what} | {run} | {c.effect:+.3f} | {_pair(c.crossed)} "
                f"| {_pair(c.runs)}; {_pair(c.drawn)} | {c.base:.3f} | {by} |"
            )
    return "\n".join(lines) + "\n"


def feedback_table(runs: pd.DataFrame) -> str:
    """By ω_t and kind of controller: merit whole, cut and frozen, settled share, following."""
    lines = [
        "| ω_t | controllers | merit | feedback cut | frozen | best run | settled | following |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for _, rows in runs.groupby(runs.omega_t.fillna(0.0).astype(str) + _kinds(runs), sort=False):
        first = rows.iloc[0]
        best = rows.merit.to_numpy()[rows.fitness.to_numpy().argmax()]
        lines.append(
            f"| {first.omega_t:g} | {_kinds(rows).iloc[0]} | {_mean(rows.merit, _MERIT)} "
            f"| {_mean(rows.merit_cut, _MERIT)} | {_mean(rows.merit_frozen, _MERIT)} "
            f"| {best:.3f} | {_mean(rows.settled, SHARE)} | {_mean(rows.following, UNBOUNDED)} |"
        )
    return "\n".join(lines) + "\n"


def _kinds(runs: pd.DataFrame) -> pd.Series:
    """The architecture and what it senses, or the short law."""
    laws = runs.architecture == LAW
    return runs.drive.where(laws, runs.architecture + "-" + runs.senses)


def _mean(values: pd.Series, within: Range) -> str:
    known = values.dropna().to_numpy()
    if len(known) < 2:
        return f"{known[0]:.3f}" if len(known) else "–"
    found = interval(known, within=within)
    return f"{found.mean:.3f} [{found.low:.3f}, {found.high:.3f}]"


def _pair(ends: tuple[float, float]) -> str:
    return f"[{ends[0]:+.3f}, {ends[1]:+.3f}]"
