"""Tables of what generalises: shares kept at each level, and between which levels half fail."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tegotae._support.tables import write_csv
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.trial import Retention, Tested
from tegotae.measures.gaits.wilson import wilson

RESAMPLES = 2000
"""How often runs are drawn anew for the interval of a margin."""


MEASURES = {"keeps": "had", "moves": "moved"}
"""What can be kept, and what it takes to have been there before."""


class Margin(NamedTuple):
    """The tested levels between which half of the runs fail, on one side of none of it."""

    condition: str
    side: str
    """"below" or "above" the neutral level."""
    runs: int
    """How many runs there are that had what can be lost."""
    survived: float
    """The last level, from none on, that more than half of the runs survive."""
    failed: float
    """The next level, which half of them or fewer survive; infinite beyond the last one tested."""
    low: float
    """Lower end of the 95 % interval of both over runs; NaN for a single run."""
    high: float
    """Upper end."""


def levels_survived(
    outcome: Retention, disturbance: Disturbance, below: bool, measure: str = ""
) -> np.ndarray:
    """How many levels in a row, from none on, each run keeps what it had, [runs].

    NaN of a run that had nothing to keep. Of a run that is released several times it is kept where
    most of them keep it.

    Args:
        outcome: of one set of controllers.
        disturbance: which.
        below: whether on the side of lower levels.
        measure: "keeps" or "moves"; the disturbance's own if empty.
    """
    measure = measure or disturbance.measure
    columns = outcome.columns
    levels = disturbance.side(below)
    mine = columns["condition"] == disturbance.name
    runs = int(columns["run"].max()) + 1 if len(columns["run"]) else 0
    alive, count = np.full(runs, True), np.zeros(runs)
    first = mine & (columns["level"] == (levels or [np.nan])[0])
    had = _per_run(outcome, first, MEASURES[measure], runs)
    for level in levels:
        alive &= _per_run(outcome, mine & (columns["level"] == level), measure, runs) > 0.5
        count += alive
    return np.where(had > 0.5, count, np.nan)


def margin(disturbance: Disturbance, below: bool, survived: np.ndarray) -> Margin:
    """The margin of runs that survive so many levels (`levels_survived`)."""
    beyond = -np.inf if below else np.inf
    levels = [disturbance.neutral, *disturbance.side(below), beyond]
    survived = survived[~np.isnan(survived)]
    side, runs = "below" if below else "above", len(survived)
    if not runs:
        return Margin(disturbance.name, side, 0, *[np.nan] * 4)
    half, nearest, farthest = median_interval(survived)
    ends = sorted((levels[nearest], levels[farthest + 1])) if runs > 1 else [np.nan] * 2
    return Margin(disturbance.name, side, runs, levels[half], levels[half + 1], *ends)


def _per_run(outcome: Retention, rows: np.ndarray, name: str, runs: int) -> np.ndarray:
    """Share of a run's releases for which a column holds, [runs]."""
    run, holds = outcome.columns["run"][rows], outcome.columns[name][rows]
    count = np.bincount(run, minlength=runs)
    return np.bincount(run, weights=holds, minlength=runs) / np.maximum(count, 1)


def median_interval(counts: np.ndarray, seed: int = 0) -> tuple[int, int, int]:
    """Median of counts, of two middle ones the lower, and its 95 % interval by the bootstrap.

    Example:
        >>> median_interval(np.array([1, 2, 2, 4]))[0]
        2
    """
    counts = np.sort(counts).astype(int)
    random = np.random.default_rng(seed)
    drawn = np.sort(random.integers(len(counts), size=(RESAMPLES, len(counts))), axis=1)
    middle = (len(counts) - 1) // 2
    medians = np.sort(counts[drawn[:, middle]])
    low, high = (int(medians[round(share * (RESAMPLES - 1))]) for share in (0.025, 0.975))
    return int(counts[middle]), low, high


def margins(
    outcome: Retention, disturbances: Sequence[Disturbance], measure: str = ""
) -> Iterator[Margin]:
    """The margins of controllers, for each side of every disturbance that they met."""
    for each in disturbances:
        if each.name in outcome.left_out:
            continue
        for below in (True, False):
            if each.side(below):
                yield margin(each, below, levels_survived(outcome, each, below, measure))


def write_tables(
    done: Sequence[tuple[Tested, Retention]],
    disturbances: Sequence[Disturbance],
    out: Path,
) -> list[Path]:
    """Write `margins.csv`, `curves.csv` and `left_out.csv` into a folder; return their paths."""
    rows: dict[str, list[dict[str, object]]] = {"margins": [], "curves": [], "left_out": []}
    for tested, outcome in done:
        for measure in MEASURES:
            for found in margins(outcome, disturbances, measure):
                rows["margins"].append(
                    {"controller": tested.name, "measure": measure, **found._asdict()}
                )
        rows["curves"] += [{"controller": tested.name, **row} for row in curve(outcome)]
        for name, why in outcome.left_out.items():
            rows["left_out"].append({"controller": tested.name, "condition": name, "why": why})
    paths = []
    for name, table in rows.items():
        if table:
            write_csv(
                out / f"{name}.csv",
                {key: [row[key] for row in table] for key in table[0]},
                digits=4,
            )
            paths.append(out / f"{name}.csv")
        else:
            (out / f"{name}.csv").unlink(missing_ok=True)  # of another run in this folder
    return paths


def share_interval(kept: int, of: int, runs: int) -> tuple[float, float]:
    """95 % interval of the share of lanes of so many runs (Wilson's score); NaN of none.

    Releases of one run are no independent trials: they count as if all of them did the same.

    Example:
        >>> [round(end, 2) for end in share_interval(60, 80, 20)]
        [0.53, 0.89]
    """
    return wilson(round(kept / of * runs), runs) if of else (np.nan, np.nan)


def curve(outcome: Retention) -> Iterator[dict[str, object]]:
    """Shares of the lanes of one set that keep what they had, level by level; the interval is
    over runs."""
    columns = outcome.columns
    for name in dict.fromkeys(columns["condition"].tolist()):
        mine = columns["condition"] == name
        for level in np.unique(columns["level"][mine]):
            at = mine & (columns["level"] == level)
            had = at & columns["had"]
            kept = columns["keeps"][had]
            runs = len(np.unique(columns["run"][had]))
            low, high = share_interval(int(kept.sum()), len(kept), runs)
            yield {
                "condition": name,
                "level": float(level),
                "lanes": int(at.sum()),
                "had": len(kept),
                "moved": int(columns["moved"][at].sum()),
                "moves": _mean(columns["moves"][at & columns["moved"]]),
                "keeps": _mean(kept),
                "keeps_low": low,
                "keeps_high": high,
                "efficiency": _median(columns["efficiency"][at]),
                "speed": _median(columns["speed"][at]),
            }


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if len(values) else np.nan


def _median(values: np.ndarray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else np.nan
