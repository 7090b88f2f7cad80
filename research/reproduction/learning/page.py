"""Tables of what learning adds, in Markdown: the primary contrasts, and every group of runs."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from research.frame import markdown_table
from research.reproduction.learning.primary import BEST_RUN, MEAN_RUN, Contrast, best_law, contrast
from research.reproduction.learning.runs import LAW
from tegotae.measures.statistics import FEW, POSITIVE, SHARE, UNBOUNDED, Range, interval


def contrasts(runs: pd.DataFrame) -> list[tuple[str, str, Contrast]]:
    """Return the primary contrasts and their sensitivity: the compared groups, the method and the
    result.
    """
    law = best_law(runs)
    over_law = f"the best short law, {law}"
    primary = [
        ("merit over V", MEAN_RUN, contrast(runs)),
        (f"merit over {over_law}", MEAN_RUN, contrast(runs, law, outcome="merit_judged")),
    ]
    best = [
        ("merit over V", BEST_RUN, contrast(runs, run=BEST_RUN)),
        (
            f"merit over {over_law}",
            BEST_RUN,
            contrast(runs, law, outcome="merit_judged", run=BEST_RUN),
        ),
    ]
    with_actuation = [
        (
            f"merit over {base}, ART and ARGT alone",
            MEAN_RUN,
            contrast(runs, name, learned=("ART", "ARGT")),
        )
        for base, name in (("V", None), ("the clock", "clock"))
    ]
    settled = [
        (f"settled share over {base}", MEAN_RUN, contrast(runs, name, outcome="settled"))
        for base, name in (("V", None), (over_law, law))
    ]
    over_clock = ("merit over the clock", MEAN_RUN, contrast(runs, "clock"))
    return [*primary, *best, over_clock, *with_actuation, *settled]


def primary_tables(readings: Mapping[str, pd.DataFrame]) -> tuple[str, str]:
    """Return the contrasts of each body, in Markdown: over all ω_t, and at each of them."""
    head = ["body", "learned feedback's", "of", "effect", "designs and ω_t random"]
    rows, by_omega = [[*head, "runs alone", "bootstrap", "base"]], []
    for body, runs in readings.items():
        for comparison, run, c in contrasts(runs):
            intervals = map(_pair, (c.crossed, c.runs, c.drawn))
            rows.append([body, comparison, run, f"{c.effect:+.3f}", *intervals, f"{c.base:.3f}"])
            effects = {f"{omega:g}": f"{value:+.2f}" for omega, value in c.of_omega.items()}
            by_omega.append({"ω_t": f"{body}: {comparison}, {run}", **effects})
    columns = list(dict.fromkeys(name for row in by_omega for name in row))
    cells = [[row.get(name, "–") for name in columns] for row in by_omega]
    return markdown_table(rows), markdown_table([columns, *cells])


def feedback_table(runs: pd.DataFrame) -> str:
    """Return the table, by ω_t and kind of controller, of merit with feedback whole, cut and
    frozen, settled share, following."""
    head = ["ω_t", "controllers", "merit", "feedback cut", "frozen", "best run", "settled"]
    lines = [[*head, "following"]]
    for _, rows in runs.groupby(runs.omega_t.fillna(0.0).astype(str) + _kinds(runs), sort=False):
        best = rows.merit.to_numpy()[rows.fitness.to_numpy().argmax()]
        variants = rows.merit, rows.merit_cut, rows.merit_frozen
        merits = [_mean(values, POSITIVE) for values in variants]
        shares = [f"{best:.3f}", _mean(rows.settled, SHARE), _mean(rows.following, UNBOUNDED)]
        lines.append([f"{rows.omega_t.iloc[0]:g}", _kinds(rows).iloc[0], *merits, *shares])
    return markdown_table(lines)


def _kinds(runs: pd.DataFrame) -> pd.Series:
    """Return the architecture and its senses, or the short law."""
    laws = runs.architecture == LAW
    return runs.drive.where(laws, runs.architecture + "-" + runs.senses)


def _mean(values: pd.Series, within: Range) -> str:
    defined = values.dropna().to_numpy()
    estimate = interval(defined, within=within)
    if len(defined) < FEW:  # V's three drives are no sample of runs
        return f"{estimate.mean:.3f}" if len(defined) else "–"
    return f"{estimate.mean:.3f} [{estimate.low:.3f}, {estimate.high:.3f}]"


def _pair(ends: tuple[float, float]) -> str:
    # Of one run each there is nothing to draw anew.
    return "–" if ends[0] == ends[1] else f"[{ends[0]:+.3f}, {ends[1]:+.3f}]"
