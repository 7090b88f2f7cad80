"""Tables of what generalises: shares kept at each level, and margins at which half fail."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tegotae._support.tables import write_csv
from tegotae.measures.gaits.wilson import wilson
from tegotae.studies.generalisation.disturbance import Disturbance
from tegotae.studies.generalisation.trial import Retention, Tested

RESAMPLES = 2000
"""How often runs are drawn anew for the interval of a margin."""


MEASURES = {"keeps": "had", "moves": "moved"}
"""What can be kept, and what it takes to have been there before."""


class Margin(NamedTuple):
    """Up to which level a disturbance is borne, on one side of none of it."""

    condition: str
    side: str
    """"below" or "above" the neutral level."""
    runs: int
    """How many runs there are that had what can be lost."""
    median: float
    """The level at which half of the runs have failed; infinite beyond the last that was tried."""
    low: float
    """Lower end of its 95 % interval over runs: nearer to the neutral level, or farther."""
    high: float
    """Upper end."""


def run_margins(
    outcome: Retention, disturbance: Disturbance, below: bool, measure: str = ""
) -> np.ndarray:
    """The level up to which each run keeps what it had, [runs].

    Half-way between the last level, from none on, at which it keeps it and the next; plus or minus
    infinity if it keeps it at all of them, NaN if it had nothing to keep. Of a run that is released
    several times it is kept where most of them keep it.

    Args:
        outcome: of one set of controllers.
        disturbance: which.
        below: whether on the side of lower levels.
        measure: "keeps" or "moves"; the disturbance's own if empty.
    """
    measure = measure or disturbance.measure
    before = MEASURES[measure]
    columns = outcome.columns
    levels = disturbance.side(below)
    mine = columns["condition"] == disturbance.name
    runs = int(columns["run"].max()) + 1 if len(columns["run"]) else 0
    alive = np.full(runs, True)
    margin = np.full(runs, -np.inf if below else np.inf)
    had = _per_run(outcome, mine & (columns["level"] == (levels or [np.nan])[0]), before, runs)
    last = disturbance.neutral
    for level in levels:
        keeps = _per_run(outcome, mine & (columns["level"] == level), measure, runs) > 0.5
        margin[alive & ~keeps] = 0.5 * (last + level)
        alive &= keeps
        last = level
    return np.where(had > 0.5, margin, np.nan)


def _per_run(outcome: Retention, rows: np.ndarray, name: str, runs: int) -> np.ndarray:
    """Share of a run's releases for which a column holds, [runs]."""
    run, holds = outcome.columns["run"][rows], outcome.columns[name][rows]
    count = np.bincount(run, minlength=runs)
    return np.bincount(run, weights=holds, minlength=runs) / np.maximum(count, 1)


def median_interval(values: np.ndarray, seed: int = 0) -> tuple[float, float, float]:
    """Median of numbers that may be infinite, and its 95 % interval by the bootstrap.

    Example:
        >>> median_interval(np.array([1.0, 2.0, np.inf]))[0]
        2.0
    """
    values = np.sort(values[~np.isnan(values)])
    if not len(values):
        return np.nan, np.nan, np.nan
    random = np.random.default_rng(seed)
    drawn = np.sort(random.integers(len(values), size=(RESAMPLES, len(values))), axis=1)
    medians = np.sort(_middle(values[drawn]))
    low, high = (medians[round(share * (RESAMPLES - 1))] for share in (0.025, 0.975))
    return float(_middle(values[None])[0]), float(low), float(high)


def _middle(rows: np.ndarray) -> np.ndarray:
    """Medians of sorted rows; of two middle values of which one is infinite the finite one."""
    n = rows.shape[1]
    low, high = rows[:, (n - 1) // 2], rows[:, n // 2]
    with np.errstate(invalid="ignore"):
        mean = 0.5 * (low + high)
    return np.where(
        np.isfinite(low) & np.isfinite(high), mean, np.where(np.isfinite(low), low, high)
    )


def margins(
    outcome: Retention, disturbances: Sequence[Disturbance], measure: str = ""
) -> Iterator[Margin]:
    """The margins of controllers, for each side of every disturbance that they met."""
    for each in disturbances:
        if each.name in outcome.left_out:
            continue
        for below in (True, False):
            if each.side(below):
                values = run_margins(outcome, each, below, measure)
                found = median_interval(values)
                side = "below" if below else "above"
                yield Margin(each.name, side, int((~np.isnan(values)).sum()), *found)


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
